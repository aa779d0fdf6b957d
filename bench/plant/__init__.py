"""A plant for bench_plant.py: stations, their controllers, a database and a broker."""
