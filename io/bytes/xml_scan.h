#pragma once
// A strict pull scanner for the XML that packages need (XML 1.0 and namespaces, UTF-8, no DTD). For this module's
// files.

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "io/bytes/input.h"

namespace argil::io {

/// `text` as it may stand between tags and in quotes: entities for what is special, '?' for what is no valid UTF-8 or
/// no character of XML. No characters by number: lib3mf does not read them. (So a line end in quotes is read as a
/// space.)
std::string xmlEscaped(std::string_view text);

/// Walks through a document element by element; what a caller does not enter is skipped, but must be well formed as far
/// as tags go:
///
///     XmlScanner xml(input, "3D/3dmodel.model");
///     xml.root();
///     for (const size_t model = xml.depth(); xml.child(model);) {
///       if (xml.is(kCore, "metadata")) title = xml.text();
///     }
///
/// A document type declaration is refused, so no entity but the five of XML and characters by number exist. Views into
/// names and values hold until the next element. Memory: the depth of the document. At least 200 MB/s on elements with
/// a few numbers.
class XmlScanner {
 public:
  struct Attribute {
    std::string_view space;  ///< Its namespace; empty for a name without prefix.
    std::string_view name;
    std::string_view value;  ///< Entities are resolved; valid UTF-8 only where utf8() says so.
  };
  static constexpr size_t kMostDepth = 64;
  static constexpr size_t kMostAttributes = 64;

  /// `input` (its bytes are the document) must outlive the scanner; `part` is named in messages beside its name. Throws
  /// Error for another encoding.
  XmlScanner(const Input& input, std::string part);

  /// Goes to the root element. Throws Error when there is none. Everything here throws Error "NAME: part PART, line N:
  /// ..." for what is not well formed.
  void root();
  /// Elements that are open: 1 in the root.
  [[nodiscard]] size_t depth() const { return open_.size(); }
  /// Goes to the next child of the element that was entered at `depth`, over the rest of the one before; false at its
  /// end, which is then left.
  bool child(size_t depth);
  /// After the last child() of the root: throws Error when anything but comments follows.
  void finish();

  /// Of the element where it stands.
  [[nodiscard]] bool is(std::string_view space, std::string_view name) const {
    return name_ == name && space_ == space;
  }
  [[nodiscard]] std::string_view name() const { return name_; }
  [[nodiscard]] std::string_view space() const { return space_; }
  [[nodiscard]] const std::vector<Attribute>& attributes() const { return attributes_; }
  /// The value of an attribute without prefix (`space`: in that namespace); null when it is not there.
  [[nodiscard]] const std::string_view* attribute(std::string_view name, std::string_view space = {}) const;
  /// Its character data up to its end, which is left; elements within are skipped. Valid UTF-8.
  std::string text();
  /// The namespace that a prefix stands for here; empty when it stands for none.
  [[nodiscard]] std::string_view spaceOf(std::string_view prefix) const;

  /// `text`, if it is valid UTF-8; throws Error otherwise.
  std::string utf8(std::string_view text) const;
  [[nodiscard]] size_t offset() const { return at_; }
  /// Throws Error "NAME: part PART, line N: WRONG".
  [[noreturn]] void fail(const std::string& wrong) const;

 private:
  enum class Event { start, end, finish };
  struct Binding {
    std::string_view prefix;
    std::string space;
    size_t depth;
  };
  struct RawAttribute {
    std::string_view prefix, name, value;
  };

  Event next(std::string* text);
  void startTag();
  void endTag();
  void passComment();
  void passInstruction();
  void passBlanks();
  std::string_view readName();
  std::string_view readValue();
  void resolve(std::string_view raw, bool isValue, std::string& to) const;
  void closeElement();
  void bindSpaces();
  [[nodiscard]] bool ahead(std::string_view what) const { return text_.substr(at_).starts_with(what); }
  [[noreturn]] void cutOff() const;

  const Input& input_;
  std::string part_;
  std::string_view text_;
  size_t at_ = 0;
  std::vector<std::string_view> open_;  ///< Names with prefix.
  bool pendingEnd_ = false;             ///< The start tag was an empty element.
  std::string_view name_, space_;
  std::vector<RawAttribute> raw_;
  std::vector<Attribute> attributes_;
  std::deque<std::string> resolved_;  ///< Values of this element that held entities.
  std::deque<Binding> bindings_;      ///< A deque: views into it must stay.
  std::string_view defaultSpace_;
};

}  // namespace argil::io
