"""From a campaign to the posterior over sets of effects: inputs, linear model, evidence, hypotheses."""
