# Placeholder for the install and export rules; filled in with the public headers.
