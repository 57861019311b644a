#include "app/config/schema_builders.h"
#include "optim/observation/camera_import.h"

namespace pathfit::app {
namespace {

SchemaNode CamerasSchema() {
  return Map("cameras",
             {Path("path", "`transforms.json`, or the folder of a COLMAP text model.").Required(),
              Choice("format", optim::CameraFormatWords(), "Kind of the camera file.")
                  .Default("auto")
                  .Refuse({{"bundler", ""}, {"opencv", ""}, {"list", ""}}),
              Choice(
                  "distortion",
                  {"model", "refuse"},
                  "`model`: rays are bent as the lens does; `refuse`: a camera with distortion is "
                  "an error.")
                  .Default("model")
                  .Refuse({{"undistort", "; write model, which needs no resampled photos"}}),
              Choice("orientation",
                     {"sensor", "exif"},
                     "`sensor`: pixels as stored, which is what camera programs work on; `exif`: "
                     "turned as the EXIF tag says.")
                  .Default("sensor")},
             "Where the photos were taken from, and through what lens.")
      .Required()
      .Refuse({{"refine", "; free camera.position and camera.rotation in unknowns"},
               {"scale", "; scale the camera file instead"},
               {"up", ""}});
}

SchemaNode MasksSchema() {
  return Map(
      "masks",
      {Path("path",
            "Folder with `a.jpg.png`, `a.png` or `a.mask.png` for the photo `a.jpg`, or `alpha`: "
            "the photos' own alpha channel.")
           .Words({"alpha"})
           .DefaultIs("as the camera file names them, else alpha"),
       Choice(
           "meaning",
           {"silhouette", "ignore"},
           "Black means: the object is not there (`silhouette`), or nothing is known (`ignore`).")
           .Default("silhouette"),
       Bool("invert", "The files have white where black is meant.").Default("false"),
       Integer("erode_px", "Width of the rim around the mask's edge that is not used.")
           .From(0, 100)
           .Unit("pixels")
           .Default("1"),
       Choice("require", {"all", "some", "none"}, "Which photos must have a mask.").Default("all")},
      "Where the object is in each photo. Absent: the photos are used whole.");
}

SchemaNode ColourSchema() {
  return Map("colour",
             {Choice(
                  "transfer",
                  {"auto", "srgb", "linear"},
                  "What the numbers in the files mean; `auto`: 8 and 16 bit are sRGB, EXR and HDR "
                  "linear.")
                  .Default("auto")
                  .Refuse({{"rec709", ""}, {"gamma", ""}}),
              Number(
                  "clip_above",
                  "Brighter pixels (share of the file's range) count as clipped: they may pull the "
                  "model up, never down. 1 = none.")
                  .From(0.5, 1.0)
                  .Default("0.99")},
             "From file values to light.")
      .Always()
      .Refuse({{"working", "; it is linear Rec.709"}, {"white_balance", ""}, {"grey_card", ""}});
}

SchemaNode ExposureSchema() {
  return Map("exposure",
             {Choice("model", {"none", "gain"}, "`gain`: each photo has its own brightness factor.")
                  .Default("none")
                  .Refuse({{"gain_rgb", "; write gain"}, {"gain_rgb_vignette", "; write gain"}}),
              Number("prior_sigma_ev", "How far from 0 an exposure is believed to be.")
                  .Above(0.0)
                  .Unit("EV")
                  .Default("0.3"),
              Number("max_ev", "Largest magnitude.").Above(0.0).Unit("EV").Default("3.0")},
             "Differences of exposure between the photos; their mean is kept.")
      .Always()
      .Refuse({{"init", "; all start at 0 EV"},
               {"gauge", "; the mean is kept at 0 EV"},
               {"bounds_ev", "; write max_ev"}});
}

}  // namespace

SchemaNode InputSchema() {
  return Map(
      "input",
      {Path("images", "Folder of the photos.").DefaultIs("as the camera file says"),
       CamerasSchema(),
       MasksSchema(),
       ColourSchema(),
       ExposureSchema(),
       Map("split",
           {Either(
                "validation",
                {Text("", ""), List("", Text("", ""), "").Items(1, 0)},
                "Photos that are never fitted and always reported: `every N` (by name, the first "
                "included), a list of file names, or `none`.")
                .Default("every 8")},
           "Which photos are held out.")
           .Always(),
       Integer("max_size_px",
               "Longest side of the photos after area averaging; `none` = as they are.")
           .From(16, 65536)
           .Unit("pixels")
           .Words({"none"})
           .Default("none")},
      "The photos. Absent for a scene that is described completely here.");
}

}  // namespace pathfit::app
