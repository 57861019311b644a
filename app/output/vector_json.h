#pragma once

#include "app/output/fields.h"
#include "renderer/math/rgb.h"
#include "renderer/math/transform.h"
#include "renderer/math/vector.h"

namespace pathfit::app {

inline Json Components(const renderer::Rgb& c) { return Json::array({c.r, c.g, c.b}); }
inline Json Components(const renderer::Vec3& v) { return Json::array({v.x, v.y, v.z}); }
/// Row by row.
inline Json RowsJson(const renderer::Mat3& m) {
  const renderer::Mat3 rows = renderer::Transposed(m);
  return Json::array({Components(rows.x), Components(rows.y), Components(rows.z)});
}

}  // namespace pathfit::app
