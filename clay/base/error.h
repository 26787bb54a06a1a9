#pragma once
// The one exception of the house.

#include <stdexcept>
#include <string>

namespace argil {

/// Work that cannot be done, as one sentence that a person can act on: what is wrong, with which file, option or value,
/// and what to do. Thrown off the real-time path only; caught at main, at a background job, at a studio command and at
/// a plugin call, nowhere else.
class Error : public std::runtime_error {
 public:
  /// `input`: the person's call or file is at fault (exit code 2); `work`: the work itself failed (exit code 1).
  enum class Kind { input, work };

  explicit Error(const std::string& sentence, Kind kind = Kind::input) : std::runtime_error(sentence), kind_(kind) {}
  [[nodiscard]] Kind kind() const noexcept { return kind_; }

 private:
  Kind kind_;
};

}  // namespace argil
