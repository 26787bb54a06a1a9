#pragma once
// A value in a script that knows where it stands: every complaint names the file and the place in it.

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "clay/base/error.h"
#include "clay/base/vec.h"
#include "io/bytes/input.h"

namespace argil::engine {

inline constexpr double kMaxMm = 1e6;  ///< Where clay may be, as clay::Grid has it.

/// All of these throw Error for what is not as asked.
class Place {
 public:
  /// `unknown`: gets the keys that are not known, with where they stand, instead of their being an error: for what a
  /// newer Argil wrote. It outlives this Place.
  Place(const nlohmann::json& value, std::string name, std::string path, std::vector<std::string>* unknown = nullptr)
      : value_(value), name_(std::move(name)), path_(std::move(path)), unknown_(unknown) {}

  [[noreturn]] void fail(const std::string& wrong) const {
    throw Error(path_.empty() ? name_ + ": " + wrong : name_ + ": " + path_ + ": " + wrong);
  }
  [[nodiscard]] Place at(const char* key) const {
    if (!value_.contains(key)) fail(fmt::format("\"{}\" is missing", key));
    return {value_[key], name_, path_.empty() ? key : path_ + "." + key, unknown_};
  }
  [[nodiscard]] std::optional<Place> maybe(const char* key) const {
    return value_.contains(key) ? std::optional(at(key)) : std::nullopt;
  }
  [[nodiscard]] std::vector<Place> items() const {
    if (!value_.is_array()) fail("must be a list [...]");
    std::vector<Place> places;
    places.reserve(value_.size());
    for (size_t i = 0; i < value_.size(); ++i)
      places.push_back({value_[i], name_, fmt::format("{}[{}]", path_, i), unknown_});
    return places;
  }
  // Of an object: its keys must be among these.
  void keys(std::initializer_list<std::string_view> known) const { keys(std::span(known.begin(), known.size())); }
  void keys(std::span<const std::string_view> known) const {
    if (!value_.is_object()) fail("must be an object {...}");
    for (const auto& [key, value] : value_.items()) {
      if (std::find(known.begin(), known.end(), key) == known.end()) {
        if (unknown_) {
          unknown_->push_back(io::shown(path_.empty() ? key : path_ + "." + key));
          continue;
        }
        fail(fmt::format("unknown key {}; known are {}", io::shown(key), fmt::join(known, ", ")));
      }
    }
  }
  [[nodiscard]] double number(double low, double high) const {
    if (!value_.is_number()) fail("must be a number");
    const double number = value_.get<double>();
    if (!(number >= low && number <= high)) fail(fmt::format("{} is out of range; use {} to {}", number, low, high));
    return number;
  }
  [[nodiscard]] double positive() const {
    if (!value_.is_number()) fail("must be a number");
    const double number = value_.get<double>();
    if (!(number > 0 && number <= kMaxMm))
      fail(fmt::format("{} is out of range; use more than 0, at most {}", number, kMaxMm));
    return number;
  }
  [[nodiscard]] bool truth() const {
    if (!value_.is_boolean()) fail("must be true or false");
    return value_.get<bool>();
  }
  [[nodiscard]] Vec3d vector() const {
    const auto places = items();
    if (places.size() != 3) fail(fmt::format("must be 3 numbers [x, y, z], and has {}", places.size()));
    return {places[0].number(-kMaxMm, kMaxMm), places[1].number(-kMaxMm, kMaxMm), places[2].number(-kMaxMm, kMaxMm)};
  }
  [[nodiscard]] const std::string& text() const {
    if (!value_.is_string()) fail("must be a text \"...\"");
    return value_.get_ref<const std::string&>();
  }
  template <class T>
  [[nodiscard]] T oneOf(std::span<const std::pair<std::string_view, T>> table) const {
    std::string known;
    for (const auto& [name, value] : table) {
      if (text() == name) return value;
      known += (known.empty() ? "" : ", ") + std::string(name);
    }
    fail(fmt::format("unknown {}; known are {}", io::shown(text()), known));
  }
  [[nodiscard]] const nlohmann::json& value() const { return value_; }

 private:
  const nlohmann::json& value_;
  std::string name_, path_;
  std::vector<std::string>* unknown_;
};

}  // namespace argil::engine
