#pragma once
// Walks through a text in memory word by word and knows the line: the ground of every text reader.

#include <cstdint>
#include <string>
#include <string_view>

#include "io/bytes/input.h"

namespace argil::io {

/// Words are separated by blanks; lines end with LF, CR LF or CR; a byte order mark before the first is passed over.
/// Never reads past the end. Nothing depends on the locale.
class TextCursor {
 public:
  struct Rules {
    bool hashComments = false;        ///< From a word that begins with # to the end of the line is a comment.
    bool backslashContinues = false;  ///< A backslash at the end of a line joins it with the next.
  };

  /// `input` must outlive the cursor.
  TextCursor(const Input& input, Rules rules)
      : input_(input), text_(input.text()), rules_(rules), at_(text_.size() - withoutMark(text_).size()) {}

  /// Skips blanks and comments; true when a word follows on this line.
  bool wordOnLine();
  /// The same, going on to later lines.
  bool wordAhead();
  /// The next word on this line; empty at its end.
  std::string_view word();
  /// The rest of this line as it stands; leaves the cursor at its end.
  std::string_view restOfLine();
  /// Leaves the line: the next word is the first of the following one.
  void skipLine();
  [[nodiscard]] bool atEnd() const { return at_ >= text_.size(); }

  /// The next word of this line (`anyLine`: or of a later one) as a finite number or as a whole number. Throws Error
  /// that names the line and `what` when there is none or it is something else.
  double number(const char* what, bool anyLine = false);
  int64_t integer(const char* what, bool anyLine = false);

  /// Of the word read last, or of the place now; counts from 1.
  [[nodiscard]] uint64_t line() const { return line_; }
  [[nodiscard]] size_t offset() const { return at_; }
  [[nodiscard]] size_t remaining() const { return text_.size() - at_; }
  /// Throws Error "NAME: line N: WRONG".
  [[noreturn]] void fail(const std::string& wrong) const;

 private:
  std::string_view required(const char* what, bool anyLine);
  void passLineEnd();

  const Input& input_;
  std::string_view text_;
  Rules rules_;
  size_t at_;
  uint64_t line_ = 1;
};

/// The whole of `word` as a number: nullopt-like false when it is none. A leading + is allowed; a number too small for
/// a double is zero; infinities and NaN are read as such, so that the caller can refuse them by name.
bool parseNumber(std::string_view word, double& value);
bool parseInteger(std::string_view word, int64_t& value);

}  // namespace argil::io
