#include "app/config/schema_builders.h"

namespace pathfit::app {

SchemaNode SceneSchema() {
  return Map("scene",
             {GeometrySchema(),
              MaterialsSchema(),
              TexturesSchema(),
              LightsSchema(),
              SensorsSchema()},
             "The model that the fit starts from. Right-handed, y up, metres.")
      .Required();
}

}  // namespace pathfit::app
