#include "haptics/contact/contact.h"

#include <array>
#include <string>

#include "clay/base/error.h"
#include "haptics/contact/ball_contact.h"
#include "haptics/contact/god_object_contact.h"
#include "haptics/contact/penalty_contact.h"

namespace argil::haptics {
namespace {

struct Row {
  std::string_view name;
  std::unique_ptr<Contact> (*make)();
};
template <class T>
std::unique_ptr<Contact> make() {
  return std::make_unique<T>();
}
constexpr std::array kRows = {
    Row{"proxy", make<BallContact>},
    Row{"god-object", make<GodObjectContact>},
    Row{"penalty", make<PenaltyContact>},
};

}  // namespace

std::unique_ptr<Contact> makeContact(std::string_view name) {
  std::string names;
  for (const Row& row : kRows) {
    if (row.name == name) return row.make();
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  throw Error("no contact is called '" + std::string(name) + "': choose one of " + names);
}

std::span<const std::string_view> contactNames() noexcept {
  static const auto names = [] {
    std::array<std::string_view, kRows.size()> all;
    for (size_t i = 0; i < all.size(); ++i) all[i] = kRows[i].name;
    return all;
  }();
  return names;
}

}  // namespace argil::haptics
