"""REST and live data over HTTP: thin routers over the services, one error shape."""
