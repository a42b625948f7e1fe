"""Which effects a scene calls for, what each way to draw it costs, and the plan that follows."""
