"""The sensing study: where to put gauges, what a budget of them buys, for one label and for two together."""
