#include "engine/tools/added_tools.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "clay/base/error.h"
#include "clay/brush/formula.h"

namespace argil::engine {

static_assert(kMostOwnNumbers == clay::Formula::kMostParameters);

namespace {

// A parameter's functions know their number alone.
struct Access {
  double (*get)(const Tool&);
  void (*set)(Tool&, double);
};
template <size_t i>
constexpr Access accessOf() {
  return {[](const Tool& t) { return t.own[i]; }, [](Tool& t, double v) { t.own[i] = v; }};
}
constexpr std::array<Access, kMostOwnNumbers> kAccess{accessOf<0>(), accessOf<1>(), accessOf<2>(), accessOf<3>(),
                                                      accessOf<4>(), accessOf<5>(), accessOf<6>(), accessOf<7>()};
constexpr std::array<clay::Operation, 1> kByFormula{{{clay::Property::distance, clay::Method::formula}}},
    kExternal{{{clay::Property::distance, clay::Method::external}}};
constexpr size_t kMostName = 60, kMostHelp = 200, kMostIcon = 400;

void requireText(std::string_view text, std::string_view what, size_t most) {
  if (text.empty() || text.size() > most)
    throw Error(fmt::format("{} of {} characters: give 1 to {}", what, text.size(), most));
  if (std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 32; }))
    throw Error(fmt::format("{} with a control character", what));
}

void requireId(std::string_view id, std::string_view what) {
  requireText(id, what, kMostName);
  if (std::any_of(id.begin(), id.end(), [](char c) {
        return !((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '.' || c == '-');
      }))
    throw Error(fmt::format("{} \"{}\": use small letters, digits, '_', '-' and '.'", what, id));
}

bool same(const AddedTool& a, const AddedTool& b) {
  const auto number = [](const AddedTool::Number& n) {
    return std::tie(n.id, n.name, n.help, n.unit, n.low, n.high, n.standard, n.logarithmic);
  };
  return std::tie(a.id, a.name, a.help, a.icon, a.formula, a.falloff, a.strength, a.inverts, a.adds) ==
             std::tie(b.id, b.name, b.help, b.icon, b.formula, b.falloff, b.strength, b.inverts, b.adds) &&
         (a.external == nullptr) == (b.external == nullptr) && (a.image == nullptr) == (b.image == nullptr) &&
         ((!a.external && !a.image) || a.origin.checksum == b.origin.checksum) &&
         std::equal(a.numbers.begin(), a.numbers.end(), b.numbers.begin(), b.numbers.end(),
                    [&](const auto& x, const auto& y) { return number(x) == number(y); });
}

// Of the program, that a tool is like.
const ToolRow& likeRow(const AddedTool& tool) {
  const std::span<const ToolRow> rows = ownTools();
  const std::string_view id = tool.image ? "emboss" : "smooth";
  return *std::find_if(rows.begin(), rows.end(), [&](const ToolRow& each) { return each.id == id; });
}

std::unique_ptr<const clay::Formula> checkedFormula(const AddedTool& tool) {
  requireId(tool.id, "a tool's id");
  requireText(tool.name, "a tool's name", kMostName);
  requireText(tool.help, "a tool's help", kMostHelp);
  // Its letters and numbers are not looked at: what is no drawing draws nothing.
  constexpr std::string_view kDrawing = "MLAZFOD0123456789.- ";
  if (tool.icon.size() > kMostIcon || tool.icon.find_first_not_of(kDrawing) != std::string::npos ||
      (!tool.icon.empty() && tool.icon[0] != 'M' && tool.icon[0] != 'O' && tool.icon[0] != 'D'))
    throw Error(
        fmt::format("{}: an icon is a drawing of {} characters at most that begins with M, O or D, such as "
                    "\"M4 20 L20 4 O12 12 5\"",
                    tool.id, kMostIcon));
  if (!(tool.strength >= 0 && tool.strength <= 1))
    throw Error(fmt::format("{}: a strength of {}: give 0 to 1", tool.id, tool.strength));
  checkNumbers(tool.numbers, tool.id);
  std::vector<std::string> names;
  for (const AddedTool::Number& number : tool.numbers) {
    if (findParameter(likeRow(tool), number.id))
      throw Error(fmt::format("{}: the number \"{}\" is there already: take another id", tool.id, number.id));
    names.push_back(number.id);
  }
  return !AddedTools::repeats(tool) ? nullptr : std::make_unique<const clay::Formula>(tool.formula, names);
}

}  // namespace

void checkNumbers(const std::vector<AddedTool::Number>& numbers, std::string_view of) {
  if (numbers.size() > kMostOwnNumbers)
    throw Error(fmt::format("{}: {} numbers: {} is the most", of, numbers.size(), kMostOwnNumbers));
  for (size_t i = 0; i < numbers.size(); ++i) {
    const AddedTool::Number& number = numbers[i];
    requireId(number.id, "a number's id");
    requireText(number.name, "a number's name", kMostName);
    requireText(number.help, "a number's help", kMostHelp);
    if (std::any_of(numbers.begin(), numbers.begin() + static_cast<ptrdiff_t>(i),
                    [&](const AddedTool::Number& other) { return other.id == number.id; }))
      throw Error(fmt::format("{}: the number \"{}\" is there already: take another id", of, number.id));
    if (!std::isfinite(number.low) || !std::isfinite(number.high) || !(number.low < number.high) ||
        !(number.standard >= number.low && number.standard <= number.high) || (number.logarithmic && number.low <= 0))
      throw Error(fmt::format("{}: {} goes from {} to {} and begins as {}: give rising numbers{}", of, number.id,
                              number.low, number.high, number.standard, number.logarithmic ? " above 0" : ""));
    constexpr std::array<std::string_view, 4> kUnits{"", "mm", "share", "°"};
    if (std::find(kUnits.begin(), kUnits.end(), number.unit) == kUnits.end())
      throw Error(fmt::format("{}: {} has the unit \"{}\": give mm, share, ° or nothing", of, number.id, number.unit));
  }
}

void checkTool(const AddedTool& tool) {
  (void)checkedFormula(tool);
}

struct AddedTools::Kept {
  AddedTool tool;
  std::unique_ptr<const clay::Formula> formula;
  std::vector<Parameter<Tool>> parameters;
};

AddedTools::AddedTools() : rows_(new ToolRow[kMost]), count_(ownTools().size()) {
  std::copy(ownTools().begin(), ownTools().end(), rows_.get());
}

const ToolRow& AddedTools::add(const AddedTool& tool) {
  const std::lock_guard lock(mutex_);
  for (const auto& kept : kept_)
    if (same(kept->tool, tool)) return *findTool(kept->tool.id);
  std::unique_ptr<const clay::Formula> formula = checkedFormula(tool);
  if (findTool(tool.id)) throw Error(fmt::format("there is another tool with the id \"{}\"", tool.id));
  if (all().size() == kMost) throw Error(fmt::format("more than {} tools", kMost));
  auto kept = std::make_unique<Kept>(Kept{tool, std::move(formula), {}});
  const ToolRow& like = likeRow(tool);
  // As a tool that rubs has them: radius, strength, its own, falloff, how the hand drives it.
  const size_t before = 2;
  kept->parameters.assign(like.parameters.begin(), like.parameters.begin() + before);
  for (size_t i = 0; i < kept->tool.numbers.size(); ++i) {
    const AddedTool::Number& number = kept->tool.numbers[i];
    Parameter<Tool> row;
    row.id = number.id;
    row.name = number.name;
    row.help = number.help;
    row.unit = number.unit;
    row.low = number.low;
    row.high = number.high;
    row.standard = number.standard;
    row.logarithmic = number.logarithmic;
    row.get = kAccess[i].get;
    row.set = kAccess[i].set;
    kept->parameters.push_back(row);
  }
  kept->parameters.insert(kept->parameters.end(), like.parameters.begin() + before, like.parameters.end());
  ToolRow row;
  row.id = kept->tool.id;
  row.name = kept->tool.name;
  row.help = kept->tool.help;
  row.icon = kept->tool.icon;
  row.group = "Plugins";
  row.operations = tool.image      ? like.operations
                   : tool.external ? std::span<const clay::Operation>(kExternal)
                                   : kByFormula;
  row.limited = like.limited;
  row.bead = like.bead;
  row.work = haptics::Work::rub;
  row.opposite = tool.inverts || tool.image ? row.id : std::string_view();
  row.parameters = kept->parameters;
  row.falloff = tool.falloff;
  row.strength = tool.strength;
  row.adds = tool.adds;
  row.formula = kept->formula.get();
  row.external = kept->tool.external.get();
  row.origin = &kept->tool.origin;
  kept_.push_back(std::move(kept));
  const size_t at = count_.load(std::memory_order_relaxed);
  rows_[at] = row;
  count_.store(at + 1, std::memory_order_release);
  return rows_[at];
}

const ToolRow& AddedTools::addBeside(AddedTool tool) {
  const std::string id = tool.id;
  for (int number = 2;; ++number) {
    {
      const std::lock_guard lock(mutex_);
      const bool known =
          std::any_of(kept_.begin(), kept_.end(), [&](const auto& kept) { return same(kept->tool, tool); });
      if (known) return *findTool(tool.id);
    }
    if (!findTool(tool.id)) return add(tool);
    tool.id = fmt::format("{}-{}", id, number);
  }
}

const AddedTool* AddedTools::addedAs(const ToolRow& row) {
  const std::lock_guard lock(mutex_);
  const auto found =
      std::find_if(kept_.begin(), kept_.end(), [&](const auto& kept) { return &kept->tool.origin == row.origin; });
  return found == kept_.end() ? nullptr : &(*found)->tool;
}

void AddedTools::explain(std::string_view id, std::string sentence) {
  const std::lock_guard lock(mutex_);
  why_[std::string(id)] = std::move(sentence);
}

std::string AddedTools::whyNot(std::string_view id) {
  const std::lock_guard lock(mutex_);
  const auto found = why_.find(id);
  return found == why_.end() ? std::string() : found->second;
}

AddedTools& addedTools() {
  static AddedTools tools;
  return tools;
}

}  // namespace argil::engine
