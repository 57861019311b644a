#pragma once

#include <string>

namespace pathfit::app {

/// Focal length, in the unit of width and height, at which an angle of view (radians) spans a side
/// of the picture: x, y, smaller, larger or diagonal.
double FocalLength(double fov, const std::string& axis, double width, double height);

}  // namespace pathfit::app
