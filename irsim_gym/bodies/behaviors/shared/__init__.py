"""What several behaviours share: steering, renewal of goals, surroundings.

Nothing that one behaviour alone needs.
"""
