"""Parts that the bakes of all methods share: visibility, chunks, the transport file, spatially varying BRDFs."""
