"""The site of the documents: MkDocs' hooks, and the pictures of its pages."""
