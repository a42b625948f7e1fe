#!/usr/bin/env bash
# Installs the Debian package on a machine that has nothing, and uses it there as a new user would.
#
#   tools/fresh_machine.sh build/installer/lightarc_VERSION_amd64.deb FOLDER
#
# The machine is a minimal Debian 12, made by debootstrap, in which apt brings what the package declares and nothing
# else. A user with an empty home draws, imports, bakes, and starts the window twice, on an Xvfb of this system, whose
# screen is saved in FOLDER. Prints installed megabytes and seconds. Needs root, debootstrap and Xvfb, and a registry of
# Debian packages. ROOT=DIR keeps the machine between calls; the package is installed anew, the home is empty again.
set -euo pipefail
[ $# -eq 2 ] || { sed -n '2,10s/^# \{0,1\}//p' "$0"; exit 2; }
package=$(realpath "$1")
out=$(realpath -m "$2")
for tool in debootstrap Xvfb chroot; do
    command -v "$tool" >/dev/null || { echo "$tool is not here: this check needs debootstrap and Xvfb (apt-get install debootstrap xvfb)"; exit 3; }
done
[ "$(id -u)" = 0 ] || { echo "only root can make a machine with debootstrap: run this with sudo"; exit 3; }
[ -f "$package" ] || { echo "$package is not there: build it with packaging/installer.py"; exit 2; }
mkdir -p "$out"
root=${ROOT:-$(mktemp -d /var/tmp/fresh-machine.XXXXXX)}
server=
finish() {
    [ -z "$server" ] || kill "$server" 2>/dev/null || true
    umount -l "$root/dev" "$root/proc" "$root/sys" 2>/dev/null || true
    [ -n "${ROOT:-}" ] || rm -rf --one-file-system "$root"
}
trap finish EXIT

if [ ! -x "$root/usr/bin/apt-get" ]; then
    # The mirror of this system, where it names one.
    mirror=$(grep -rhoE 'https?://[^ ]+/debian/?( |$)' /etc/apt/sources.list /etc/apt/sources.list.d 2>/dev/null | head -n 1 | tr -d ' ' || true)
    debootstrap --variant=minbase bookworm "$root" ${mirror:+"$mirror"} >"$out/debootstrap.log" 2>&1 || { tail -n 3 "$out/debootstrap.log"; exit 1; }
    cp /etc/resolv.conf "$root/etc/" 2>/dev/null || true
    cp /etc/apt/apt.conf.d/99* "$root/etc/apt/apt.conf.d/" 2>/dev/null || true
fi
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev" && mount --make-rslave "$root/dev"
mount -t sysfs sysfs "$root/sys" 2>/dev/null || true

machine() { # as root there
    chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
}
user() { # as a user there, in the home
    chroot --userspec=artist:artist "$root" /usr/bin/env -i HOME=/home/artist PATH=/usr/bin:/bin LANG=C.UTF-8 \
        DISPLAY="${display:-}" XDG_RUNTIME_DIR=/tmp sh -c "cd; $1" </dev/null
}

cp "$package" "$root/var/tmp/lightarc.deb"
machine apt-get update -q >"$out/apt.log" 2>&1
machine apt-get install -y -q --no-install-recommends --reinstall /var/tmp/lightarc.deb >>"$out/apt.log" 2>&1 || { tail -n 5 "$out/apt.log"; exit 1; }
rm "$root/var/tmp/lightarc.deb"
machine sh -c 'id artist >/dev/null 2>&1 || useradd --create-home artist; find /home/artist -mindepth 1 -delete; chown artist: /home/artist'
echo "installed: $(du -s --apparent-size -B MB "$root/usr/lib/lightarc" | cut -f1) in /usr/lib/lightarc, $(du -s --apparent-size -B MB "$root/usr/lib/lightarc/kernels" 2>/dev/null | cut -f1) of it kernels"

timed() { # NAME COMMAND: seconds of a command
    local begun=$EPOCHREALTIME code=0
    user "$2" >"$out/$1.log" 2>&1 || code=$?
    awk -v a="$begun" -v b="$EPOCHREALTIME" -v name="$1" -v code="$code" 'BEGIN {printf "%s: %.1f s, exit %d\n", name, b - a, code}'
    [ "$code" = 0 ] || { tail -n 3 "$out/$1.log"; exit 1; }
}
compiled() { user 'find .cache/lightarc/kernels-* -name "*.nbc" -type f 2>/dev/null | wc -l'; }

timed version 'lightarc --version'
timed render 'lightarc render sphere --brdf ggx --width 200 --height 150 -o sphere.png'
echo "first progress of a bake: $(user '
    lightarc bake sphere --brdf ggx --mode sh --order 3 --cube 16 --no-check -o ball.transport 2>progress.log >bake.log &
    begun=$(date +%s%N)
    while kill -0 $! 2>/dev/null && [ ! -s progress.log ]; do sleep 0.02; done
    echo "$((($(date +%s%N) - begun) / 1000000)) ms"
    wait $!')"
timed bake 'lightarc bake sphere --brdf ggx --mode sh --order 3 --cube 16 --no-check --overwrite -o ball.transport'
timed simulate 'lightarc simulate -o photographs --size 64'
timed import 'lightarc import photographs -o stack'
timed shade 'lightarc shade stack -o cloth.lightarc'
timed relight 'lightarc render sphere --material cloth.lightarc --width 200 --height 150 -o cloth.png'
echo "kernels compiled by these: $(compiled)"
cp "$root"/home/artist/*.png "$out/"

exec 3<>"$out/display"
Xvfb -displayfd 3 -screen 0 1280x800x24 -nolisten tcp >"$out/xvfb.log" 2>&1 &
server=$!
for _ in $(seq 100); do [ -s "$out/display" ] && break; sleep 0.1; done
display=":$(tr -d '\n' <"$out/display")"
cat >"$root/home/artist/watch.py" <<'PYTHON'
"""Seconds until the window shows more than one colour, and then its image after some more."""

import subprocess
import sys
import time

from PySide6.QtGui import QGuiApplication

words, image, rest_s = sys.argv[1].split(), sys.argv[2], float(sys.argv[3])
application = QGuiApplication([])
begun = time.monotonic()
window = subprocess.Popen(words)
while time.monotonic() - begun < 120.0 and window.poll() is None:
    shot = application.primaryScreen().grabWindow(0).toImage().scaled(64, 40)
    if len({shot.pixel(x, y) for x in range(64) for y in range(40)}) > 8:
        break
    time.sleep(0.05)
print(f"{time.monotonic() - begun:.1f} s")
time.sleep(rest_s)
application.primaryScreen().grabWindow(0).save(image)
window.terminate()
try:
    code = window.wait(30)
except subprocess.TimeoutExpired:
    window.kill()
    code = "killed"
print(f"exit {code}", file=sys.stderr)
PYTHON
python=$(cd "$root" && ls usr/lib/lightarc/python/bin/python3*)
for start in first second; do
    echo "$start start of the window: $(user "/$python -I watch.py 'lightarc gui --sample' $start.png 25" 2>"$out/window-$start.log")"
done
cp "$root"/home/artist/{first,second}.png "$out/"
echo "kernels compiled in all: $(compiled)"
