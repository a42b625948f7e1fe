"""Addresses of clusters: only those of this machine, or with TLS, unless a user asks for others."""

from __future__ import annotations

import pytest

from engine.core.cluster import check_cluster
from engine.core.errors import UsageError

HERE = (
    "tcp://127.0.0.1:8786",
    "tcp://127.9.9.9:1",
    "ws://[::1]:1",
    "tcp://localhost:99/",
    "tls://a.b:1",
    "wss://[::2]:1",
)
ELSEWHERE = ("tcp://a.b:99/", "tcp://192.168.0.10:8786", "ws://[::2]:1", "tcp://localhost.example:1", "tcp://0.0.0.0:1")


@pytest.mark.parametrize("address", HERE)
def test_addresses_with_tls_or_of_this_machine(address: str) -> None:
    assert check_cluster(address) == address


@pytest.mark.parametrize("address", ELSEWHERE)
def test_plain_addresses_elsewhere_have_to_be_asked_for(address: str) -> None:
    assert check_cluster(address, allow_plain=True) == address
    with pytest.raises(UsageError, match=r"has no TLS.*--plain-cluster"):
        check_cluster(address)


@pytest.mark.parametrize(
    "address", ["", "127.0.0.1:8786", "tcp://", "tcp://a", "file:///x:1", "tcp://a:b", "tcp://a b:1"]
)
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(UsageError, match="not an address"):
        check_cluster(address, allow_plain=True)
