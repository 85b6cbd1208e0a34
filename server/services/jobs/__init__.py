"""Work on a rig that outlasts a request: identification sessions and campaigns."""
