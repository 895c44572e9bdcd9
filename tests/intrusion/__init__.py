"""What somebody would try who wants more than they may."""
