"""Variations over the model in the View workspace: of parameters of the BRDF, of BRDFs, of colours."""
