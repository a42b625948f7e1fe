"""BRDFs: evaluation, importance sampling, tables, scattered samples and fits."""
