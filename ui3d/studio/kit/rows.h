#pragma once
// Settings as rows of tables, so that a new one needs no panel code: numbers (engine::Parameter), switches, choices.

#include <algorithm>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "engine/document/parameter.h"
#include "ui3d/studio/kit/kit.h"

namespace argil::studio {

/// On or off.
template <class Owner>
struct Switch {
  std::string_view id, name, help;
  bool Owner::*on = nullptr;
};

/// One of a few.
template <class Owner>
struct Choice {
  std::string_view id, name, help;
  std::span<const std::string_view> options;
  int (*get)(const Owner&) = nullptr;
  void (*set)(Owner&, int) = nullptr;
};

template <class Owner>
using Row = std::variant<engine::Parameter<Owner>, Switch<Owner>, Choice<Owner>>;

/// What a person did to rows in this frame.
template <class Owner>
struct Touched {
  /// `ended`: a drag or typing is over, so the next change is a step of its own.
  bool changed = false, ended = false;
  std::string_view id, name;  ///< Of the row.
  /// Where something changed: gives any owner what was chosen, and nothing else. For owners that are changed later, by
  /// another thread: a whole owner would undo what was chosen on other rows meanwhile.
  std::function<void(Owner&)> set;
};

template <class Owner>
Touched<Owner> drawRow(const engine::Parameter<Owner>& row, Owner& owner, float width = 0) {
  double value = row.get(owner);
  kit::Change change;
  if (!row.choices.empty()) {
    int chosen = int(value);
    change.changed = change.ended = kit::choice(row.name, row.choices, chosen, row.help);
    value = chosen;
  } else if (row.unit == "on") {
    bool on = value >= 0.5;
    change.changed = change.ended = kit::toggle(row.name, on, row.help);
    value = on;
  } else if (row.unit == "colour") {
    change = kit::colour(row.name, value, row.help);
  } else {
    const bool share = row.unit == "share";
    const double scale = share ? 100 : 1;
    value *= scale;
    change = kit::number({row.id, row.name, row.help, share ? std::string_view("%") : row.unit, row.low * scale,
                          row.high * scale, row.standard * scale, row.logarithmic, row.zero},
                         value, width);
    value /= scale;
  }
  Touched<Owner> touched{change.changed, change.ended, row.id, row.name, {}};
  if (change.changed) {
    touched.set = [set = row.set, value = std::clamp(value, row.low, row.high)](Owner& each) { set(each, value); };
    touched.set(owner);
  }
  return touched;
}
template <class Owner>
Touched<Owner> drawRow(const Switch<Owner>& row, Owner& owner) {
  const bool changed = kit::toggle(row.name, owner.*row.on, row.help);
  return {changed, changed, row.id, row.name,
          [member = row.on, on = owner.*row.on](Owner& each) { each.*member = on; }};
}
template <class Owner>
Touched<Owner> drawRow(const Choice<Owner>& row, Owner& owner) {
  int chosen = row.get(owner);
  const bool changed = kit::choice(row.name, row.options, chosen, row.help);
  if (changed) row.set(owner, chosen);
  return {changed, changed, row.id, row.name, [set = row.set, chosen](Owner& each) { set(each, chosen); }};
}

template <class Owner>
Touched<Owner> drawRows(std::span<const engine::Parameter<Owner>> rows, Owner& owner) {
  Touched<Owner> touched;
  for (const auto& row : rows) {
    if (Touched<Owner> t = drawRow(row, owner); t.changed || t.ended) touched = std::move(t);
  }
  return touched;
}
template <class Owner>
Touched<Owner> drawRows(std::span<const Row<Owner>> rows, Owner& owner) {
  Touched<Owner> touched;
  for (const auto& row : rows) {
    Touched<Owner> t = std::visit([&](const auto& each) { return drawRow(each, owner); }, row);
    if (t.changed || t.ended) touched = std::move(t);
  }
  return touched;
}

}  // namespace argil::studio
