"""The founding paper reproduced: its ten numbers, its trends, its figures 6 to 19.

"Simple and effective method to predict the occupant dynamic response under sudden impulse loads" (the copy at hand
prints no authors). Its vehicle is not printed; the one used here is a reconstruction that meets the ten numbers.
"""
