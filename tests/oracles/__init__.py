"""What results are held against: the equations to the letter, and the planar arm in closed form."""
