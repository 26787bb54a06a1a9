#include "engine/models/cut_negatives.h"

#include <fmt/format.h>

#include <utility>

#include "clay/base/error.h"
#include "clay/import/mesh_to_clay.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"

namespace argil::engine {

clay::Version withoutNegatives(clay::Version version, uint32_t assembly, const std::vector<io::ModelObject>& negatives,
                               std::vector<std::string>& notes, Job* job) {
  clay::ImportOptions options;
  options.grid = version.grid();
  options.placeOrigin = false;
  for (const io::ModelObject& negative : negatives) {
    if (negative.assembly != assembly) continue;
    const std::string name = negative.name.empty() ? "A negative volume" : negative.name;
    try {
      const clay::Imported made = clay::meshToClay(clay::Store::make(), negative.mesh, options, job);
      version = clay::combine(version, made.version, clay::Combination::cut, {}, job);
      notes.push_back(fmt::format("{} was cut away, as the file says.", name));
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& e) {
      notes.push_back(fmt::format("{} should be cut away and was left out: {}.", name, e.what()));
    }
  }
  return version;
}

}  // namespace argil::engine
