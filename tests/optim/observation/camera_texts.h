// One camera as other programs write it, 200 x 120 pixels: their documentation tells where it sees
// a point.
#pragma once

namespace pathfit::tests {

inline constexpr const char* kOpencvYaml = R"(%YAML:1.0
---
calibration_time: "Tue 3 Mar 2026"
image_width: 200
image_height: 120
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 200., 0., 100., 0., 400., 59.75,
       0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ 0.128, 1.6384, 0.16, 0.32, 0. ]
extrinsic_parameters: !!opencv-matrix
   rows: 1
   cols: 6
   dt: d
   data: [ 1.2091995761561452, 1.2091995761561452, 1.2091995761561452, 1., 2., 3. ]
images: [ "a photo.png" ]
)";

inline constexpr const char* kOpencvXml = R"(<?xml version="1.0"?>
<opencv_storage>
<image_Width>200</image_Width>
<image_Height>120</image_Height>
<Camera_Matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>200. 0. 100. 0. 400. 59.75 0. 0. 1.</data></Camera_Matrix>
<Distortion_Coefficients type_id="opencv-matrix"><rows>5</rows><cols>1</cols><dt>d</dt>
  <data>0.128 1.6384 0.16 0.32 0.</data></Distortion_Coefficients>
<rvecs><_ type_id="opencv-matrix"><rows>3</rows><cols>1</cols><dt>d</dt>
  <data>1.2091995761561452 1.2091995761561452 1.2091995761561452</data></_></rvecs>
<tvecs><_ type_id="opencv-matrix"><rows>3</rows><cols>1</cols><dt>d</dt>
  <data>1. 2. 3.</data></_></tvecs>
<images>"a photo.png"</images>
</opencv_storage>
)";

inline constexpr const char* kMetashape = R"(<?xml version="1.0" encoding="UTF-8"?>
<document version="1.5.0">
  <chunk label="Chunk 1" enabled="true">
    <sensors next_id="1">
      <sensor id="0" label="unknown" type="frame">
        <resolution width="200" height="120"/>
        <calibration type="frame" class="initial"><f>1</f></calibration>
        <calibration type="frame" class="adjusted">
          <resolution width="200" height="120"/>
          <f>400</f><cx>0.5</cx><cy>0.25</cy><k1>0.128</k1><k2>1.6384</k2><p1>0.32</p1><p2>0.16</p2>
          <b1>-200</b1>
        </calibration>
      </sensor>
    </sensors>
    <components next_id="1"><component id="0" label="Component 1"></component></components>
    <cameras next_id="3" next_group_id="1">
      <camera id="0" sensor_id="0" component_id="0" label="a photo">
        <transform>0 1 0 -2 0 0 1 -3 1 0 0 -1 0 0 0 1</transform>
      </camera>
      <camera id="1" sensor_id="0" label="not aligned"/>
      <group id="0" label="g"><camera id="2" sensor_id="0" component_id="0" label="b.jpg">
        <transform>0 1 0 -2 0 0 1 -3 1 0 0 -1 0 0 0 1</transform></camera></group>
    </cameras>
  </chunk>
</document>
)";

inline constexpr const char* kAliceVision = R"({"version": ["1", "2", "6"],
"featuresFolders": [],
"views": [{"viewId": "5", "poseId": "5", "intrinsicId": "9", "path": "/elsewhere/a photo.jpg",
           "width": "200", "height": "120"},
          {"viewId": "6", "poseId": "6", "intrinsicId": "9", "path": "b.jpg"}],
"intrinsics": [{"intrinsicId": "9", "width": "200", "height": "120", "sensorWidth": "36",
  "type": "brown", "focalLength": "36", "pixelRatio": "2", "principalPoint": ["0.5", "0.25"],
  "distortionParams": ["0.128", "1.6384", "0", "0.16", "0.32"]}],
"poses": [{"poseId": "5", "pose": {"transform": {
  "rotation": ["0", "1", "0", "0", "0", "1", "1", "0", "0"], "center": ["-2", "-3", "-1"]},
  "locked": "0"}}]})";

}  // namespace pathfit::tests
