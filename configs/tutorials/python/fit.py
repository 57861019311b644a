"""A fit to photos, watched, stopped and continued: fit.py CONFIG FOLDER."""
import sys

import numpy as np
import pathfit

config, folder = sys.argv[1:]
away = {"scene.geometry.ball.transform.translate_m": [0.1, -0.05, 0.55],
        "scene.materials.paint.base_color.constant": [0.4, 0.4, 0.4]}


def watch(figures):
    if figures["round"] in (1, 4, 5):
        print("round", figures["round"], "cost", f"{figures['cost_total']:.2e}")
    return figures["round"] < 4 or resumed  # False stops


resumed = False
result = pathfit.Scene(config, away).fit(on_round=watch, checkpoints=folder)
print(result["status"], "after", result["rounds"], "rounds")

resumed = True
scene = pathfit.Scene(config, away)  # what the fit began with
result = scene.fit(
    on_round=watch,
    on_stage=lambda figures: print("stage", figures["stage"], "fitted PSNR", f"{figures['psnr_srgb_fit_db']:.1f} dB"),
    on_view=lambda stage, view, picture, photo: print("  ", view, "largest difference", f"{abs(picture[..., :3] - photo).max():.2f}"),
    checkpoints=folder,
    resume=True,
)
print(result["status"], "after", result["rounds"], "rounds")
place = scene.values(scene.parameters(["ball.translation"]))
paint = scene.values(scene.parameters(["paint.base_color"]))
error = result["standard_errors"]["paint.base_color"]
print("paint", np.round(paint, 3).tolist(), "+-", np.round(error, 4).tolist())
assert np.allclose(paint, [0.7, 0.3, 0.2], atol=0.02)
