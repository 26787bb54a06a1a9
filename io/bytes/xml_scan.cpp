#include "io/bytes/xml_scan.h"

#include <algorithm>
#include <charconv>
#include <utility>

namespace argil::io {

namespace {

/// Of all elements that are open: no real document has more than a dozen, and each is looked at for a prefix.
constexpr size_t kMostBindings = 64;
constexpr std::string_view kXmlSpace = "http://www.w3.org/XML/1998/namespace";

enum : uint8_t { kNameStart = 1, kNameMore = 2, kBlank = 4, kPlainValue = 8 };

constexpr std::array<uint8_t, 256> makeClasses() {
  std::array<uint8_t, 256> classes{};
  for (int c = 0; c < 256; ++c) {
    uint8_t& flags = classes[static_cast<size_t>(c)];
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c >= 0x80;
    if (letter) flags |= kNameStart;
    if (letter || (c >= '0' && c <= '9') || c == '-' || c == '.') flags |= kNameMore;
    if (c == ' ' || c == '\t' || c == '\n' || c == '\r') flags |= kBlank;
    // What need not be looked at: no quote, no entity, no tag, no blank that becomes a space, no control character.
    if (c >= 0x20 && c != '"' && c != '\'' && c != '<' && c != '&') flags |= kPlainValue;
  }
  return classes;
}
constexpr std::array<uint8_t, 256> kClasses = makeClasses();

bool has(char c, uint8_t flags) {
  return (kClasses[static_cast<unsigned char>(c)] & flags) != 0;
}

bool isCharacter(uint32_t code) {
  return code == 9 || code == 10 || code == 13 || (code >= 0x20 && code < 0xd800) ||
         (code >= 0xe000 && code < 0xfffe) || (code >= 0x10000 && code < 0x110000);
}

void appendUtf8(std::string& to, uint32_t code) {
  const auto more = [&](int shift) { to += static_cast<char>(0x80 | ((code >> shift) & 0x3f)); };
  if (code < 0x80) {
    to += static_cast<char>(code);
  } else if (code < 0x800) {
    to += static_cast<char>(0xc0 | (code >> 6));
    more(0);
  } else if (code < 0x10000) {
    to += static_cast<char>(0xe0 | (code >> 12));
    more(6);
    more(0);
  } else {
    to += static_cast<char>(0xf0 | (code >> 18));
    more(12);
    more(6);
    more(0);
  }
}

/// Bytes of the character that `text` begins with; 0 when it is no valid UTF-8. Shortest forms only, as RFC 3629 says.
size_t characterBytes(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  if (first < 0x80) return 1;
  const size_t more = first >= 0xf0 ? 3 : first >= 0xe0 ? 2 : 1;
  if (first < 0xc2 || first > 0xf4 || text.size() <= more) return 0;
  uint32_t code = first & (0x3fu >> more);
  for (size_t k = 1; k <= more; ++k) {
    const auto byte = static_cast<unsigned char>(text[k]);
    if ((byte & 0xc0) != 0x80) return 0;
    code = code << 6 | (byte & 0x3f);
  }
  constexpr uint32_t kLeast[] = {0, 0x80, 0x800, 0x10000};
  return code < kLeast[more] || !isCharacter(code) ? 0 : 1 + more;
}

bool isUtf8(std::string_view text) {
  while (!text.empty()) {
    const size_t bytes = characterBytes(text);
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

constexpr std::pair<std::string_view, char> kEntities[] = {
    {"lt", '<'}, {"gt", '>'}, {"amp", '&'}, {"apos", '\''}, {"quot", '"'}};

bool equalIgnoringCase(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return (x >= 'A' && x <= 'Z' ? x - 'A' + 'a' : x) == y; });
}

}  // namespace

std::string xmlEscaped(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const size_t bytes = characterBytes(text);
    const char c = text[0];
    const auto* entity =
        std::find_if(std::begin(kEntities), std::end(kEntities), [&](const auto& each) { return each.second == c; });
    if (entity != std::end(kEntities)) {
      result.append("&").append(entity->first).append(";");
    } else if (bytes == 0 || (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t')) {
      result += '?';
    } else {
      result += text.substr(0, bytes);
    }
    text.remove_prefix(std::max<size_t>(bytes, 1));
  }
  return result;
}

XmlScanner::XmlScanner(const Input& input, std::string part)
    : input_(input), part_(std::move(part)), text_(input.text()) {
  if (text_.starts_with("\xff\xfe") || text_.starts_with("\xfe\xff")) fail("is written in UTF-16; save it as UTF-8");
  if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;
  if (!ahead("<?xml") || text_.size() - at_ < 6 || !has(text_[at_ + 5], kBlank)) return;
  const size_t end = text_.find("?>", at_);
  if (end == std::string_view::npos) cutOff();
  const std::string_view declaration = text_.substr(at_, end - at_);
  const size_t encoding = declaration.find("encoding");
  if (encoding != std::string_view::npos) {
    const size_t open = declaration.find_first_of("\"'", encoding);
    const size_t close = open == std::string_view::npos ? open : declaration.find(declaration[open], open + 1);
    if (close == std::string_view::npos) fail("names no encoding; save it as UTF-8");
    const std::string_view name = declaration.substr(open + 1, close - open - 1);
    if (!equalIgnoringCase(name, "utf-8") && !equalIgnoringCase(name, "us-ascii"))
      fail("is written in " + shown(name) + "; save it as UTF-8");
  }
  at_ = end + 2;
}

void XmlScanner::fail(const std::string& wrong) const {
  const auto line =
      1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, text_.size())), '\n');
  io::fail(input_.name, "part " + shown(part_) + ", line " + std::to_string(line) + ": " + wrong);
}

void XmlScanner::cutOff() const {
  fail("the text ends too early; it was cut off, export it again");
}

void XmlScanner::root() {
  if (next(nullptr) != Event::start) fail("there is no element; export it again");
}

bool XmlScanner::child(size_t depth) {
  for (;;) {
    const Event event = next(nullptr);
    if (event == Event::finish) cutOff();
    if (event == Event::start ? open_.size() == depth + 1 : open_.size() < depth) return event == Event::start;
  }
}

void XmlScanner::finish() {
  while (!open_.empty()) next(nullptr);
  if (next(nullptr) != Event::finish) fail("a second document follows; repair it or export it again");
}

std::string XmlScanner::text() {
  const size_t level = open_.size();
  std::string result;
  while (open_.size() >= level) next(open_.size() == level ? &result : nullptr);
  return utf8(result);
}

std::string XmlScanner::utf8(std::string_view text) const {
  if (!isUtf8(text)) fail("a text is no valid UTF-8; save it as UTF-8");
  return std::string(text);
}

const std::string_view* XmlScanner::attribute(std::string_view name, std::string_view space) const {
  for (const Attribute& each : attributes_) {
    if (each.name == name && each.space == space) return &each.value;
  }
  return nullptr;
}

std::string_view XmlScanner::spaceOf(std::string_view prefix) const {
  if (prefix == "xml") return kXmlSpace;
  for (auto binding = bindings_.rbegin(); binding != bindings_.rend(); ++binding) {
    if (binding->prefix == prefix) return binding->space;
  }
  return {};
}

XmlScanner::Event XmlScanner::next(std::string* text) {
  if (pendingEnd_) {
    pendingEnd_ = false;
    closeElement();
    return Event::end;
  }
  for (;;) {
    const size_t tag = std::min(text_.find('<', at_), text_.size());
    const std::string_view between = text_.substr(at_, tag - at_);
    if (open_.empty() && !std::all_of(between.begin(), between.end(), [](char c) { return has(c, kBlank); }))
      fail("text stands outside of all elements; export it again");
    if (text != nullptr) resolve(between, false, *text);
    at_ = tag;
    if (at_ == text_.size()) {
      if (!open_.empty()) cutOff();
      return Event::finish;
    }
    const char kind = at_ + 1 < text_.size() ? text_[at_ + 1] : '\0';
    if (kind == '/') {
      endTag();
      return Event::end;
    }
    if (kind == '?') {
      passInstruction();
    } else if (kind != '!') {
      startTag();
      return Event::start;
    } else if (ahead("<!--")) {
      passComment();
    } else if (ahead("<![CDATA[") && !open_.empty()) {
      constexpr size_t kOpening = 9;
      const size_t end = text_.find("]]>", at_ + kOpening);
      if (end == std::string_view::npos) cutOff();
      if (text != nullptr) text->append(text_.substr(at_ + kOpening, end - at_ - kOpening));
      at_ = end + 3;
    } else {
      fail("a document type declaration or worse stands there; packages may not have one, remove it");
    }
  }
}

void XmlScanner::passComment() {
  const size_t end = text_.find("--", at_ + 4);
  if (end == std::string_view::npos || end + 2 >= text_.size()) cutOff();
  if (text_[end + 2] != '>') fail("a comment holds \"--\"; repair it or export it again");
  at_ = end + 3;
}

void XmlScanner::passInstruction() {
  const size_t end = text_.find("?>", at_ + 2);
  if (end == std::string_view::npos) cutOff();
  at_ = end + 2;
}

void XmlScanner::passBlanks() {
  while (at_ < text_.size() && has(text_[at_], kBlank)) ++at_;
}

std::string_view XmlScanner::readName() {
  const size_t begin = at_;
  if (at_ < text_.size() && has(text_[at_], kNameStart)) {
    while (at_ < text_.size() && has(text_[at_], kNameMore)) ++at_;
  }
  if (at_ == text_.size()) cutOff();
  if (at_ == begin) fail("a name should stand there; export it again");
  return text_.substr(begin, at_ - begin);
}

std::string_view XmlScanner::readValue() {
  passBlanks();
  if (at_ >= text_.size()) cutOff();
  if (text_[at_] != '=') fail("an attribute has no value; export it again");
  ++at_;
  passBlanks();
  if (at_ >= text_.size()) cutOff();
  const char quote = text_[at_];
  if (quote != '"' && quote != '\'') fail("the value of an attribute has no quotes; export it again");
  const size_t begin = ++at_;
  bool plain = true;
  for (;; ++at_) {
    while (at_ < text_.size() && has(text_[at_], kPlainValue)) ++at_;
    if (at_ >= text_.size()) cutOff();
    if (text_[at_] == quote) break;
    if (text_[at_] == '<') fail("'<' stands within a value; export it again");
    if (text_[at_] != '"' && text_[at_] != '\'') plain = false;
  }
  const std::string_view value = text_.substr(begin, at_ - begin);
  ++at_;
  if (plain) return value;
  resolved_.emplace_back();
  resolve(value, true, resolved_.back());
  return resolved_.back();
}

void XmlScanner::resolve(std::string_view raw, bool isValue, std::string& to) const {
  for (size_t i = 0; i < raw.size(); ++i) {
    const char c = raw[i];
    if (c == '&') {
      const size_t end = raw.find(';', i);
      if (end == std::string_view::npos) fail("'&' stands alone; write &amp; or export it again");
      const std::string_view entity = raw.substr(i + 1, end - i - 1);
      const auto* known = std::find_if(std::begin(kEntities), std::end(kEntities),
                                       [&](const auto& each) { return each.first == entity; });
      if (known != std::end(kEntities)) {
        to += known->second;
      } else {
        const bool hexadecimal = entity.starts_with("#x");
        const std::string_view digits = entity.substr(std::min<size_t>(entity.size(), hexadecimal ? 2 : 1));
        uint32_t code = 0;
        const auto [stop, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), code, hexadecimal ? 16 : 10);
        if (!entity.starts_with('#') || error != std::errc() || stop != digits.data() + digits.size() ||
            !isCharacter(code)) {
          fail("the entity " + shown(entity) + " is not known; packages have only those of XML, export it again");
        }
        appendUtf8(to, code);
      }
      i = end;
    } else if (has(c, kBlank)) {
      // Line ends become one, and all blanks in values become spaces: XML 1.0, 2.11 and 3.3.3.
      if (c == '\r' && i + 1 < raw.size() && raw[i + 1] == '\n') continue;
      to += isValue ? ' ' : c == '\r' ? '\n' : c;
    } else {
      if (static_cast<unsigned char>(c) < 0x20) fail("a control character stands in a text; export it again");
      to += c;
    }
  }
}

void XmlScanner::startTag() {
  if (open_.size() >= kMostDepth)
    fail("more than " + std::to_string(kMostDepth) + " elements are nested; it may be an attack, do not use it");
  const size_t nameBegin = ++at_;
  std::string_view prefix;
  std::string_view name = readName();
  if (text_[at_] == ':') {
    ++at_;
    prefix = name;
    name = readName();
  }
  open_.push_back(text_.substr(nameBegin, at_ - nameBegin));
  raw_.clear();
  resolved_.clear();
  bool declares = false;
  for (;;) {
    const size_t before = at_;
    passBlanks();
    if (at_ >= text_.size()) cutOff();
    if (text_[at_] == '>') {
      ++at_;
      break;
    }
    if (text_[at_] == '/') {
      if (at_ + 1 >= text_.size()) cutOff();
      if (text_[at_ + 1] != '>') fail("'/' stands within a tag; export it again");
      at_ += 2;
      pendingEnd_ = true;
      break;
    }
    if (at_ == before) fail("no blank stands before an attribute; export it again");
    RawAttribute attribute;
    attribute.name = readName();
    if (text_[at_] == ':') {
      ++at_;
      attribute.prefix = attribute.name;
      attribute.name = readName();
    }
    attribute.value = readValue();
    for (const RawAttribute& other : raw_) {
      if (other.name == attribute.name && other.prefix == attribute.prefix)
        fail("the attribute " + shown(attribute.name) + " stands twice; export it again");
    }
    if (raw_.size() >= kMostAttributes)
      fail("an element has more than " + std::to_string(kMostAttributes) +
           " attributes; it may be an attack, do not use it");
    declares = declares || attribute.prefix == "xmlns" || (attribute.prefix.empty() && attribute.name == "xmlns");
    raw_.push_back(attribute);
  }
  if (declares) bindSpaces();
  const auto known = [&](std::string_view of) {
    const std::string_view space = spaceOf(of);
    if (space.empty()) fail("the prefix " + shown(of) + " stands for nothing; export it again");
    return space;
  };
  name_ = name;
  space_ = prefix.empty() ? defaultSpace_ : known(prefix);
  attributes_.clear();
  for (const RawAttribute& each : raw_) {
    const bool binds = each.prefix == "xmlns" || (each.prefix.empty() && each.name == "xmlns");
    if (!binds)
      attributes_.push_back({each.prefix.empty() ? std::string_view() : known(each.prefix), each.name, each.value});
  }
}

void XmlScanner::bindSpaces() {
  for (const RawAttribute& each : raw_) {
    const bool isDefault = each.prefix.empty() && each.name == "xmlns";
    if (!isDefault && each.prefix != "xmlns") continue;
    if (bindings_.size() >= kMostBindings) fail("there are too many namespaces; it may be an attack, do not use it");
    bindings_.push_back({isDefault ? std::string_view() : each.name, std::string(each.value), open_.size()});
  }
  defaultSpace_ = spaceOf({});
}

void XmlScanner::endTag() {
  at_ += 2;
  const size_t begin = at_;
  (void)readName();
  if (text_[at_] == ':') {
    ++at_;
    (void)readName();
  }
  const std::string_view name = text_.substr(begin, at_ - begin);
  if (open_.empty() || open_.back() != name)
    fail("the element " + shown(open_.empty() ? name : open_.back()) +
         " is not closed where it should be; export it again");
  passBlanks();
  if (at_ >= text_.size()) cutOff();
  if (text_[at_] != '>') fail("a closing tag holds more than a name; export it again");
  ++at_;
  closeElement();
}

void XmlScanner::closeElement() {
  const bool bound = !bindings_.empty() && bindings_.back().depth == open_.size();
  while (!bindings_.empty() && bindings_.back().depth == open_.size()) bindings_.pop_back();
  if (bound) defaultSpace_ = spaceOf({});
  open_.pop_back();
}

}  // namespace argil::io
