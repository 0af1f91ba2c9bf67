"""The registry of named objects, built in or from plugins, and the check of what plugins return."""
