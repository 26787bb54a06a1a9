#pragma once
// Moments in a person's words, in local time.

#include <chrono>
#include <filesystem>
#include <string>

namespace argil::studio {

using Moment = std::chrono::system_clock::time_point;

/// "12:31".
[[nodiscard]] std::string clockTime(Moment moment);
/// "today", "yesterday", "18 November", "18 November 2024" as it is seen at `now`.
[[nodiscard]] std::string dayWords(Moment moment, Moment now);
/// "12:31" of today, else "yesterday 12:31" and so on.
[[nodiscard]] std::string momentWords(Moment moment, Moment now);
/// "today, 12:03 to 12:31"; "yesterday 23:50 to today 0:10"; one time where both are the same minute.
[[nodiscard]] std::string spanWords(Moment from, Moment to, Moment now);
/// When a file was written last; the epoch when that cannot be known.
[[nodiscard]] Moment writtenAt(const std::filesystem::path& file);

}  // namespace argil::studio
