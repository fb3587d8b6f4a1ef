class NotAScene(Exception): pass
def import_scene(*a, **k): raise NotAScene("later")
