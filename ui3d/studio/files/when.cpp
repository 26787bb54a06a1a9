#include "ui3d/studio/files/when.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <array>
#include <ctime>
#include <string_view>

namespace argil::studio {
namespace {

constexpr std::array<std::string_view, 12> kMonths{"January",   "February", "March",    "April",
                                                   "May",       "June",     "July",     "August",
                                                   "September", "October",  "November", "December"};

std::tm local(Moment moment) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(moment);
  std::tm parts{};
  ::localtime_r(&seconds, &parts);
  return parts;
}

bool sameDay(const std::tm& a, const std::tm& b) {
  return a.tm_year == b.tm_year && a.tm_yday == b.tm_yday;
}

// Noon of the day before: days of 23 and 25 hours do not matter there.
std::tm dayBefore(std::tm day) {
  day.tm_mday -= 1;
  day.tm_hour = 12;
  day.tm_isdst = -1;
  (void)std::mktime(&day);
  return day;
}

}  // namespace

std::string clockTime(Moment moment) {
  const std::tm parts = local(moment);
  return fmt::format("{}:{:02}", parts.tm_hour, parts.tm_min);
}

std::string dayWords(Moment moment, Moment now) {
  const std::tm day = local(moment), today = local(now);
  if (sameDay(day, today)) return "today";
  if (sameDay(day, dayBefore(today))) return "yesterday";
  const std::string words = fmt::format("{} {}", day.tm_mday, kMonths[size_t(day.tm_mon)]);
  return day.tm_year == today.tm_year ? words : fmt::format("{} {}", words, day.tm_year + 1900);
}

std::string momentWords(Moment moment, Moment now) {
  const std::string day = dayWords(moment, now), time = clockTime(moment);
  return day == "today" ? time : day + " " + time;
}

std::string spanWords(Moment from, Moment to, Moment now) {
  const std::string day = dayWords(from, now), lastDay = dayWords(to, now), begin = clockTime(from),
                    end = clockTime(to);
  if (day != lastDay) return fmt::format("{} {} to {} {}", day, begin, lastDay, end);
  return begin == end ? fmt::format("{}, {}", day, begin) : fmt::format("{}, {} to {}", day, begin, end);
}

Moment writtenAt(const std::filesystem::path& file) {
  struct stat facts {};
  if (::stat(file.c_str(), &facts) != 0) return {};
  return std::chrono::system_clock::from_time_t(facts.st_mtim.tv_sec);
}

}  // namespace argil::studio
