#include "app/config/field_of_view.h"

#include <algorithm>
#include <cmath>

namespace pathfit::app {
namespace {

double SideOf(const std::string& axis, double width, double height) {
  if (axis == "x") return width;
  if (axis == "y") return height;
  if (axis == "larger") return std::max(width, height);
  if (axis == "diagonal") return std::hypot(width, height);
  return std::min(width, height);
}

}  // namespace

double FocalLength(double fov, const std::string& axis, double width, double height) {
  return 0.5 * SideOf(axis, width, height) / std::tan(0.5 * fov);
}

}  // namespace pathfit::app
