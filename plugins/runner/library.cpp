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

const argil_brush* Library::brush(const char* id) const {
  for (uint32_t i = 0; i < kMostThings; ++i) {
    const auto* brush = static_cast<const argil_brush*>(plugin_->get(ARGIL_BRUSH_1, i));
    if (brush == nullptr) return nullptr;
    if (ARGIL_HAS(brush, bricks) && brush->id != nullptr && brush->bricks != nullptr && std::strcmp(brush->id, id) == 0)
      return brush;
  }
  return nullptr;
}

}  // namespace argil::plugin
