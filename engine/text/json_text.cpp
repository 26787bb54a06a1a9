#include "engine/text/json_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <vector>

#include "clay/base/error.h"
#include "io/bytes/input.h"

namespace argil::engine {

using nlohmann::json;

namespace {

constexpr int kMaxDepth = 16;  // a script has 6

}  // namespace

// A key twice in an object would silently win over the first; a deep nest would only exhaust the stack.
json parseJson(std::string_view text, const std::string& name, const std::string& what) {
  std::vector<std::set<std::string>> open;
  const auto watch = [&](int depth, json::parse_event_t event, json& parsed) {
    using Event = json::parse_event_t;
    if (depth > kMaxDepth) throw Error(fmt::format("{}: brackets nest deeper than {}; {}", name, kMaxDepth, what));
    if (event == Event::object_start) open.emplace_back();
    if (event == Event::object_end) open.pop_back();
    if (event == Event::key && !open.back().insert(parsed.get<std::string>()).second) {
      throw Error(fmt::format("{}: the key {} is there twice in one object; remove one", name,
                              io::shown(parsed.get<std::string>())));
    }
    return true;
  };
  try {
    return json::parse(text, watch);
  } catch (const json::parse_error& error) {
    const std::string_view before = text.substr(0, std::min(text.size(), error.byte > 0 ? error.byte - 1 : 0));
    const size_t line = 1 + static_cast<size_t>(std::count(before.begin(), before.end(), '\n'));
    const size_t column =
        before.size() - (before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1) + 1;
    throw Error(fmt::format("{}: line {}, column {}: not JSON here; {}", name, line, column, what));
  } catch (const json::exception&) {  // a number beyond any double
    throw Error(fmt::format("{}: holds a number that is out of range", name));
  }
}

}  // namespace argil::engine
