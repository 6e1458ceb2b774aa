"""The job `fit`: from measured speeds to restitution, friction and impact speed."""
