#include "plugins/runner/library.h"

#include <dlfcn.h>

#include <cstddef>
#include <cstring>
#include <type_traits>

namespace argil::plugin {

namespace {

constexpr uint32_t kMostThings = 1000;  // of a kind

// Whether a struct of a plugin reaches to the end of a member.
#define ARGIL_HAS(thing, member) \
  ((thing)->size >= offsetof(std::remove_cvref_t<decltype(*(thing))>, member) + sizeof((thing)->member))

}  // namespace

void Library::load(const char* file) {
  handle_ = ::dlopen(file, RTLD_NOW | RTLD_LOCAL);
  if (handle_ == nullptr) {
    const char* why = ::dlerror();
    throw Refused{Refusal::cannotLoad, why != nullptr ? why : "no reason is known"};
  }
}

void Library::enter(const argil_host& host) {
  const auto entry = reinterpret_cast<const argil_plugin* (*)()>(::dlsym(handle_, ARGIL_PLUGIN_SYMBOL));
  if (entry == nullptr) throw Refused{Refusal::noEntry, "it does not export " ARGIL_PLUGIN_SYMBOL};
  plugin_ = entry();
  if (plugin_ == nullptr) throw Refused{Refusal::nothing, ARGIL_PLUGIN_SYMBOL "() says that it cannot work here"};
  if (!ARGIL_HAS(plugin_, get) || plugin_->id == nullptr || plugin_->version == nullptr || plugin_->init == nullptr ||
      plugin_->deinit == nullptr || plugin_->get == nullptr)
    throw Refused{Refusal::nothing, "its argil_plugin lacks members"};
  if (plugin_->init(&host) != ARGIL_OK) throw Refused{Refusal::initFailed, "its init() failed"};
}

template <class Thing>
const Thing* Library::find(const char* kind, const char* id, size_t least) const {
  for (uint32_t i = 0; i < kMostThings; ++i) {
    const auto* thing = static_cast<const Thing*>(plugin_->get(kind, i));
    if (thing == nullptr) return nullptr;
    if (thing->size >= least && thing->id != nullptr && std::strcmp(thing->id, id) == 0) return thing;
  }
  return nullptr;
}

#define ARGIL_UP_TO(type, member) (offsetof(type, member) + sizeof(type::member))

const argil_brush* Library::brush(const char* id) const {
  const auto* brush = find<argil_brush>(ARGIL_BRUSH_1, id, ARGIL_UP_TO(argil_brush, bricks));
  return brush != nullptr && brush->bricks != nullptr ? brush : nullptr;
}

const argil_exporter* Library::exporter(const char* id) const {
  const auto* exporter = find<argil_exporter>(ARGIL_EXPORTER_1, id, ARGIL_UP_TO(argil_exporter, end));
  return exporter != nullptr && exporter->begin != nullptr && exporter->object != nullptr &&
                 exporter->vertices != nullptr && exporter->triangles != nullptr
             ? exporter
             : nullptr;
}

const argil_importer* Library::importer(const char* id) const {
  const auto* importer = find<argil_importer>(ARGIL_IMPORTER_1, id, ARGIL_UP_TO(argil_importer, run));
  return importer != nullptr && importer->run != nullptr ? importer : nullptr;
}

const argil_operation* Library::operation(const char* id) const {
  const auto* operation = find<argil_operation>(ARGIL_OPERATION_1, id, ARGIL_UP_TO(argil_operation, run));
  return operation != nullptr && operation->run != nullptr ? operation : nullptr;
}

const argil_guide* Library::guide(const char* id) const {
  const auto* guide = find<argil_guide>(ARGIL_GUIDE_1, id, ARGIL_UP_TO(argil_guide, update));
  return guide != nullptr && guide->begin != nullptr && guide->update != nullptr ? guide : nullptr;
}

const argil_texture* Library::texture(const char* id) const {
  const auto* texture = find<argil_texture>(ARGIL_TEXTURE_1, id, ARGIL_UP_TO(argil_texture, heights));
  return texture != nullptr && texture->heights != nullptr ? texture : nullptr;
}

const argil_device* Library::device(const char* id) const {
  const auto* device = find<argil_device>(ARGIL_DEVICE_1, id, ARGIL_UP_TO(argil_device, exchange));
  return device != nullptr && device->begin != nullptr && device->exchange != nullptr ? device : nullptr;
}

}  // namespace argil::plugin
