#include "clay/brush/formula.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <tuple>

#include "clay/base/error.h"

namespace argil::clay {

namespace {

constexpr std::array<FormulaName, kFormulaInputs> kInputs{{
    {"phi", "Distance from the surface in mm, below zero inside."},
    {"mean", "Mean of phi over the 27 voxels around, near ones more."},
    {"weight", "Of the tip: 1 in its middle at full strength, 0 at its rim."},
    {"x", "Place in the piece, mm."},
    {"y", "Place in the piece, mm."},
    {"z", "Place in the piece, mm."},
    {"u", "From the tip's path along its first axis, in radii."},
    {"v", "From the tip's path along its second axis, in radii."},
    {"w", "From the tip's path along its third axis, in radii."},
    {"r", "From the tip's path, in radii: 0 in its middle, 1 at its rim."},
    {"nx", "Outward normal of the surface."},
    {"ny", "Outward normal of the surface."},
    {"nz", "Outward normal of the surface."},
    {"radius", "Of the tip, mm."},
    {"strength", "Of the tip: 0 to 1."},
    {"voxel", "Edge of a voxel, mm."},
}};

struct Function {
  FormulaName name;
  int operands;
};
constexpr std::array kFunctions{
    Function{{"min", "The lesser."}, 2},
    Function{{"max", "The greater."}, 2},
    Function{{"abs", "Without its sign."}, 1},
    Function{{"sqrt", "Square root; of what is below 0: 0."}, 1},
    Function{{"floor", "The next whole number below."}, 1},
    Function{{"fract", "What is above that: 0 to 1."}, 1},
    Function{{"sin", "Of radians."}, 1},
    Function{{"cos", "Of radians."}, 1},
    Function{{"clamp", "The first, no less than the second and no more than the third."}, 3},
    Function{{"mix", "From the first to the second by the third, 0 to 1."}, 3},
    Function{{"smoothstep", "From 0 to 1 while the third goes from the first to the second, level at both."}, 3},
    Function{{"length", "Of a vector of three."}, 3},
    Function{{"noise", "Of a place: smooth hills and valleys, −1 to 1, about 2 apart."}, 3},
};
constexpr auto kFunctionNames = [] {
  std::array<FormulaName, kFunctions.size()> names{};
  for (size_t i = 0; i < names.size(); ++i) names[i] = kFunctions[i].name;
  return names;
}();

constexpr uint16_t kNone = 0xffff;
constexpr double kHalfPi = 1.5707963267948966;

}  // namespace

std::span<const FormulaName, kFormulaInputs> formulaInputs() {
  return kInputs;
}
std::span<const FormulaName> formulaFunctions() {
  return kFunctionNames;
}

/// From a text to steps: equal subexpressions once, constants folded by the steps themselves, registers used again.
class FormulaCompiler {
 public:
  FormulaCompiler(Formula& formula, std::span<const std::string> parameters)
      : formula_(formula), text_(formula.text_), parameters_(parameters) {}

  void compile() {
    uint16_t value = kNone;
    for (;;) {
      skip();
      const size_t before = at_;
      const std::string name = word();
      skip();
      if (!name.empty() && peek() == '=' && text_.substr(at_, 2) != "==") {
        ++at_;
        define(name, before, choice());
        expect(';');
        continue;
      }
      at_ = before;
      value = choice();
      skip();
      if (peek() == ';') ++at_;
      skip();
      if (at_ < text_.size()) fail("nothing may follow the value that it gives");
      break;
    }
    place(value);
  }

 private:
  struct Node {
    FormulaStep step;
    std::array<uint16_t, 3> from;
    auto key() const { return std::tuple(step, from); }
  };

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(fmt::format("formula, character {}: {}", at_ + 1, what));
  }
  [[nodiscard]] char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void skip() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\n' || text_[at_] == '\t' || text_[at_] == '\r'))
      ++at_;
  }
  bool take(std::string_view sign) {
    skip();
    if (text_.substr(at_, sign.size()) != sign) return false;
    at_ += sign.size();
    return true;
  }
  void expect(char sign) {
    if (!take(std::string_view(&sign, 1))) fail(fmt::format("'{}' is missing", sign));
  }
  static bool letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
  static bool digit(char c) { return c >= '0' && c <= '9'; }
  std::string word() {
    const size_t from = at_;
    if (letter(peek()))
      while (letter(peek()) || digit(peek())) ++at_;
    return std::string(text_.substr(from, at_ - from));
  }

  // Places. Nodes come behind inputs, parameters and constants of as many as there can be at most.
  static constexpr uint16_t kFirstParameter = kFormulaInputs,
                            kFirstConstant = kFirstParameter + Formula::kMostParameters,
                            kFirstNode = kFirstConstant + Formula::kMostText;

  uint16_t constant(double value) {
    const auto rounded = static_cast<float>(value);
    auto& all = formula_.constants_;
    const auto found = std::find_if(all.begin(), all.end(), [&](float each) { return each == rounded; });
    const auto index = static_cast<size_t>(found - all.begin());
    if (found == all.end()) all.push_back(rounded);
    return static_cast<uint16_t>(kFirstConstant + index);
  }
  uint16_t node(FormulaStep step, uint16_t a, uint16_t b = kNone, uint16_t c = kNone) {
    const Node made{step, {a, b, c}};
    // Numbers alone are a number.
    const auto number = [&](uint16_t from) { return from == kNone || (from >= kFirstConstant && from < kFirstNode); };
    if (number(a) && number(b) && number(c)) {
      FormulaOperand operands[3];
      for (size_t i = 0; i < 3; ++i)
        if (made.from[i] != kNone) operands[i] = {&formula_.constants_[made.from[i] - size_t{kFirstConstant}], true};
      float value = 0;
      runFormulaStep(step, operands, &value);
      return constant(static_cast<double>(value));
    }
    const auto [it, fresh] = known_.try_emplace(made.key(), static_cast<uint16_t>(kFirstNode + nodes_.size()));
    if (fresh) nodes_.push_back(made);
    if (nodes_.size() > Formula::kMostSteps)
      fail(fmt::format("more than {} steps: make it shorter", Formula::kMostSteps));
    return it->second;
  }

  void define(const std::string& name, size_t at, uint16_t value) {
    const auto taken = [&](const auto& names) {
      return std::any_of(names.begin(), names.end(), [&](const FormulaName& each) { return each.name == name; });
    };
    if (taken(kInputs) || taken(kFunctionNames) || named_.contains(name) ||
        std::find(parameters_.begin(), parameters_.end(), name) != parameters_.end()) {
      at_ = at;
      fail(fmt::format("\"{}\" has a meaning already: take another name", name));
    }
    named_[name] = value;
  }

  /// Deeper by one as long as it lives.
  struct Deeper {
    explicit Deeper(FormulaCompiler& of) : of_(of) {
      if (++of_.depth_ > Formula::kMostDepth) of_.fail("too deep: give parts of it names");
    }
    ~Deeper() { --of_.depth_; }
    Deeper(const Deeper&) = delete;
    Deeper& operator=(const Deeper&) = delete;
    FormulaCompiler& of_;
  };

  uint16_t choice() {
    const Deeper deeper(*this);
    const uint16_t condition = comparison();
    if (!take("?")) return condition;
    const uint16_t yes = choice();
    expect(':');
    return node(FormulaStep::choose, condition, yes, choice());
  }
  uint16_t comparison() {
    const uint16_t a = sum();
    if (take("<=")) return node(FormulaStep::lessEqual, a, sum());
    if (take(">=")) return node(FormulaStep::lessEqual, sum(), a);
    if (take("<")) return node(FormulaStep::less, a, sum());
    if (take(">")) return node(FormulaStep::less, sum(), a);
    return a;
  }
  uint16_t sum() {
    uint16_t a = product();
    for (;;) {
      if (take("+"))
        a = node(FormulaStep::add, a, product());
      else if (take("-"))
        a = node(FormulaStep::subtract, a, product());
      else
        return a;
    }
  }
  uint16_t product() {
    uint16_t a = sign();
    for (;;) {
      if (take("*"))
        a = node(FormulaStep::multiply, a, sign());
      else if (take("/"))
        a = node(FormulaStep::divide, a, sign());
      else
        return a;
    }
  }
  uint16_t sign() {
    const Deeper deeper(*this);
    if (take("-")) return node(FormulaStep::subtract, constant(0), sign());
    if (take("+")) return sign();
    return atom();
  }
  uint16_t atom() {
    skip();
    if (take("(")) {
      const uint16_t inside = choice();
      expect(')');
      return inside;
    }
    if (digit(peek()) || peek() == '.') {
      double value = 0;
      const auto [end, problem] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
      if (problem != std::errc() || !std::isfinite(static_cast<float>(value))) fail("no number that can be used");
      at_ = static_cast<size_t>(end - text_.data());
      return constant(value);
    }
    const size_t before = at_;
    const std::string name = word();
    if (name.empty()) fail(at_ < text_.size() ? "a value is missing here" : "a value is missing at the end");
    skip();
    if (peek() == '(') return call(name, before);
    if (const auto it = named_.find(name); it != named_.end()) return it->second;
    for (size_t i = 0; i < kInputs.size(); ++i)
      if (kInputs[i].name == name) {
        formula_.reads_ |= 1u << i;
        return static_cast<uint16_t>(i);
      }
    for (size_t i = 0; i < parameters_.size(); ++i)
      if (parameters_[i] == name) return static_cast<uint16_t>(kFirstParameter + i);
    at_ = before;
    fail(fmt::format("\"{}\" is not known", name));
  }
  uint16_t call(const std::string& name, size_t before) {
    const auto function = std::find_if(kFunctions.begin(), kFunctions.end(),
                                       [&](const Function& each) { return each.name.name == name; });
    if (function == kFunctions.end()) {
      at_ = before;
      fail(fmt::format("there is no function \"{}\"", name));
    }
    expect('(');
    std::array<uint16_t, 3> a{kNone, kNone, kNone};
    for (int i = 0; i < function->operands; ++i) {
      if (i > 0) expect(',');
      a[static_cast<size_t>(i)] = choice();
    }
    expect(')');
    using enum FormulaStep;
    const auto squared = [&](uint16_t of) { return node(multiply, of, of); };
    if (name == "min") return node(least, a[0], a[1]);
    if (name == "max") return node(most, a[0], a[1]);
    if (name == "abs") return node(absolute, a[0]);
    if (name == "sqrt") return node(root, a[0]);
    if (name == "floor") return node(floor, a[0]);
    if (name == "fract") return node(subtract, a[0], node(floor, a[0]));
    if (name == "sin") return node(sine, a[0]);
    if (name == "cos") return node(sine, node(add, a[0], constant(kHalfPi)));
    if (name == "clamp") return node(least, node(most, a[0], a[1]), a[2]);
    if (name == "mix") return node(add, a[0], node(multiply, a[2], node(subtract, a[1], a[0])));
    if (name == "length") return node(root, node(add, node(add, squared(a[0]), squared(a[1])), squared(a[2])));
    if (name == "smoothstep") {
      const uint16_t way = node(divide, node(subtract, a[2], a[0]), node(subtract, a[1], a[0])),
                     t = node(least, node(most, way, constant(0)), constant(1));
      return node(multiply, squared(t), node(subtract, constant(3), node(multiply, constant(2), t)));
    }
    return node(noise, a[0], a[1], a[2]);
  }

  // Nodes in order into registers, each of which is free again behind the last that reads it.
  void place(uint16_t value) {
    const auto index = [](uint16_t node) { return node - size_t{kFirstNode}; };
    std::vector<bool> needed(nodes_.size());
    if (value >= kFirstNode) needed[index(value)] = true;
    for (size_t i = nodes_.size(); i-- > 0;)
      if (needed[i])
        for (const uint16_t from : nodes_[i].from)
          if (from != kNone && from >= kFirstNode) needed[index(from)] = true;
    std::vector<size_t> last(nodes_.size());
    for (size_t i = 0; i < nodes_.size(); ++i)
      if (needed[i])
        for (const uint16_t from : nodes_[i].from)
          if (from != kNone && from >= kFirstNode) last[index(from)] = i;
    if (value >= kFirstNode) last[index(value)] = nodes_.size();
    const auto firstRegister = static_cast<uint16_t>(kFirstConstant + formula_.constants_.size());
    std::vector<uint16_t> at(nodes_.size(), kNone), spare;
    const auto placeOf = [&](uint16_t of) {
      return of == kNone || of < kFirstNode ? of : static_cast<uint16_t>(firstRegister + at[index(of)]);
    };
    for (size_t i = 0; i < nodes_.size(); ++i) {
      if (!needed[i]) continue;
      Formula::Step step{nodes_[i].step, {}, 0};
      for (size_t k = 0; k < 3; ++k) step.from[k] = placeOf(nodes_[i].from[k]);
      for (const uint16_t from : nodes_[i].from)
        if (from != kNone && from >= kFirstNode && last[index(from)] == i &&
            std::find(spare.begin(), spare.end(), at[index(from)]) == spare.end())
          spare.push_back(at[index(from)]);
      if (spare.empty()) spare.push_back(formula_.registers_++);
      at[i] = spare.back();
      spare.pop_back();
      step.to = placeOf(static_cast<uint16_t>(kFirstNode + i));
      formula_.steps_.push_back(step);
    }
    formula_.result_ = placeOf(value);
  }

  Formula& formula_;
  std::string_view text_;
  std::span<const std::string> parameters_;
  size_t at_ = 0, depth_ = 0;
  std::vector<Node> nodes_;
  std::map<std::tuple<FormulaStep, std::array<uint16_t, 3>>, uint16_t> known_;
  std::map<std::string, uint16_t> named_;
};

Formula::Formula(std::string text, std::span<const std::string> parameters)
    : text_(std::move(text)), parameters_(parameters.size()) {
  if (text_.size() > kMostText)
    throw Error(fmt::format("a formula of {} characters: {} is the most", text_.size(), kMostText));
  if (parameters.size() > kMostParameters)
    throw Error(fmt::format("a formula with {} parameters: {} is the most", parameters.size(), kMostParameters));
  FormulaCompiler(*this, parameters).compile();
}

void Formula::run(std::span<const FormulaOperand, kFormulaInputs> inputs, std::span<const float> parameters,
                  float (&out)[kBrickVoxels]) const {
  struct Register {
    float values[kBrickVoxels];
  };
  thread_local std::vector<Register> room;
  thread_local std::vector<bool> one;
  if (room.size() < registers_) room.resize(registers_);
  one.assign(registers_, false);
  const size_t firstConstant = kFormulaInputs + kMostParameters, firstRegister = firstConstant + constants_.size();
  const auto operandAt = [&](uint16_t place) -> FormulaOperand {
    if (place == kNone) return {};
    if (place < kFormulaInputs) return inputs[place];
    if (place < firstConstant) return {&parameters[place - kFormulaInputs], true};
    if (place < firstRegister) return {&constants_[place - firstConstant], true};
    const size_t at = place - firstRegister;
    return {room[at].values, one[at]};
  };
  for (const Step& each : steps_) {
    const FormulaOperand operands[3] = {operandAt(each.from[0]), operandAt(each.from[1]), operandAt(each.from[2])};
    const size_t to = each.to - firstRegister;
    runFormulaStep(each.step, operands, room[to].values);
    one[to] = std::all_of(std::begin(operands), std::end(operands),
                          [](const FormulaOperand& o) { return !o.values || o.one; });
  }
  const FormulaOperand result = operandAt(result_);
  if (result.one)
    std::fill(std::begin(out), std::end(out), *result.values);
  else
    std::copy_n(result.values, kBrickVoxels, out);
}

}  // namespace argil::clay
