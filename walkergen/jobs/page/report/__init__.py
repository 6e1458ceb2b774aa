"""The job `report`: a family on one HTML page that opens offline."""
