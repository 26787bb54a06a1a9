#include "io/bytes/text_cursor.h"

#include <charconv>
#include <cmath>
#include <limits>

namespace argil::io {

namespace {

bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}
bool isLineEnd(char c) {
  return c == '\n' || c == '\r';
}

}  // namespace

bool parseNumber(std::string_view word, double& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (stop != end || error == std::errc::invalid_argument) return false;
  if (error == std::errc::result_out_of_range) {
    // from_chars does not say which way: a number written with a negative exponent, or as a fraction, was too small.
    const size_t exponent = word.find_first_of("eE");
    const bool tiny = exponent != std::string_view::npos ? word[exponent + 1] == '-' : word.find('.') < 3;
    value = tiny ? 0 : std::numeric_limits<double>::infinity();
  }
  return true;
}

bool parseInteger(std::string_view word, int64_t& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  return stop == end && error == std::errc();
}

void TextCursor::passLineEnd() {
  if (text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n') ++at_;
  ++at_;
  ++line_;
}

bool TextCursor::wordOnLine() {
  while (at_ < text_.size()) {
    const char c = text_[at_];
    if (isBlank(c)) {
      ++at_;
    } else if (isLineEnd(c)) {
      return false;
    } else if (c == '#' && rules_.hashComments) {
      while (at_ < text_.size() && !isLineEnd(text_[at_])) ++at_;
      return false;
    } else if (c == '\\' && rules_.backslashContinues && at_ + 1 < text_.size() && isLineEnd(text_[at_ + 1])) {
      ++at_;
      passLineEnd();
    } else {
      return true;
    }
  }
  return false;
}

bool TextCursor::wordAhead() {
  while (!wordOnLine()) {
    if (atEnd()) return false;
    passLineEnd();
  }
  return true;
}

std::string_view TextCursor::word() {
  if (!wordOnLine()) return {};
  const size_t begin = at_;
  while (at_ < text_.size() && !isBlank(text_[at_]) && !isLineEnd(text_[at_])) {
    if (text_[at_] == '\\' && rules_.backslashContinues && at_ + 1 < text_.size() && isLineEnd(text_[at_ + 1])) break;
    ++at_;
  }
  return text_.substr(begin, at_ - begin);
}

std::string_view TextCursor::restOfLine() {
  const size_t begin = at_;
  while (at_ < text_.size() && !isLineEnd(text_[at_])) ++at_;
  return text_.substr(begin, at_ - begin);
}

void TextCursor::skipLine() {
  while (at_ < text_.size() && !isLineEnd(text_[at_])) {
    const bool continued =
        text_[at_] == '\\' && rules_.backslashContinues && at_ + 1 < text_.size() && isLineEnd(text_[at_ + 1]);
    ++at_;
    if (continued) passLineEnd();
  }
  if (at_ < text_.size()) passLineEnd();
}

std::string_view TextCursor::required(const char* what, bool anyLine) {
  if (anyLine ? !wordAhead() : !wordOnLine()) {
    if (atEnd()) fail(std::string("the file ends where ") + what + " should stand; it was cut off, export it again");
    fail(std::string("the line ends where ") + what + " should stand; repair the line or export again");
  }
  return word();
}

double TextCursor::number(const char* what, bool anyLine) {
  const std::string_view token = required(what, anyLine);
  double value = 0;
  if (!parseNumber(token, value)) fail(shown(token) + " stands where " + what + " should; a number is needed");
  if (!std::isfinite(value))
    fail(std::string(what) + " is " + shown(token) + "; only finite numbers can be used, repair it");
  return value;
}

int64_t TextCursor::integer(const char* what, bool anyLine) {
  const std::string_view token = required(what, anyLine);
  int64_t value = 0;
  if (!parseInteger(token, value)) fail(shown(token) + " stands where " + what + " should; a whole number is needed");
  return value;
}

void TextCursor::fail(const std::string& wrong) const {
  io::fail(input_.name, "line " + std::to_string(line_) + ": " + wrong);
}

}  // namespace argil::io
