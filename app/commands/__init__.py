"""Commands of the workspaces on the document, each the work of a job."""
