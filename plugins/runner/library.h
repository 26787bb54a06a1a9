#pragma once
// A plugin's library, loaded and looked through. Nothing that it says is believed but that its pointers can be read: if
// they cannot, the process ends, which is what it is for.

#include <string>

#include "plugins/runner/channel.h"

namespace argil::plugin {

/// Why a library cannot be used.
struct Refused {
  Refusal why;
  std::string sentence;
};

class Library {
 public:
  /// dlopen(): constructors run. Throws Refused.
  void load(const char* file);
  /// argil_plugin_1() and init(). `host` has to stay. Throws Refused; what the plugin said is in the channel.
  void enter(const argil_host& host);

  [[nodiscard]] const argil_plugin& plugin() const { return *plugin_; }
  /// Null: it has none of that id.
  [[nodiscard]] const argil_brush* brush(const char* id) const;
  [[nodiscard]] const argil_exporter* exporter(const char* id) const;
  [[nodiscard]] const argil_importer* importer(const char* id) const;
  [[nodiscard]] const argil_operation* operation(const char* id) const;
  [[nodiscard]] const argil_guide* guide(const char* id) const;
  [[nodiscard]] const argil_texture* texture(const char* id) const;
  [[nodiscard]] const argil_device* device(const char* id) const;

 private:
  template <class Thing>
  [[nodiscard]] const Thing* find(const char* kind, const char* id, size_t least) const;

  void* handle_ = nullptr;
  const argil_plugin* plugin_ = nullptr;
};

}  // namespace argil::plugin
