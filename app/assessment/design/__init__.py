"""What a therapist draws on a template: compiled for whoever judges, changed by whoever may."""
