"""What makes the site: pages are copied or generated into a folder that Sphinx reads."""
