#pragma once
// What a disk may hold after a power cut: a trace (write_trace.h) up to some moment, less what was not flushed by then.
//
// The model is the one of ALICE (Pillai et al., OSDI 2014) and of SQLite's own crash tests: what fsync of a file came
// after is there, with the length that it had; of the rest any part may be there, down to single sectors, in any order,
// with zeros or rubbish where the length grew and the bytes did not come. Entries of a folder are there once the folder
// was flushed; of later ones the first few, or (stricter than any file system that is in use) any.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/support/write_trace.h"

namespace argil::failing {

class CutDisk {
 public:
  /// `ignores`: flushes that this disk does not carry out, to see whether anybody notices. Null: none. The trace must
  /// outlive this.
  using Ignores = std::function<bool(const Trace&, size_t op)>;
  explicit CutDisk(const Trace& trace, Ignores ignores = {});

  /// Goes on to the moment after so many operations. Forward only.
  void advance(size_t ops);
  /// What is lost.
  enum class Loss : uint8_t {
    nothing,  ///< As when a program is killed.
    all,      ///< Whatever was not flushed.
    some,     ///< By chance, each file and folder in its own way.
  };
  /// Files by their path below the root; folders end with a slash.
  [[nodiscard]] std::map<std::string, std::string> image(Loss loss, uint64_t seed) const;

 private:
  struct Node {
    bool folder = false;
    std::string bytes;                        // flushed
    std::map<std::string, uint32_t> entries;  // flushed
    std::vector<const TraceOp*> since;        // not flushed
  };
  [[nodiscard]] static std::string content(const Node& node, Loss loss, uint64_t seed);
  [[nodiscard]] static std::map<std::string, uint32_t> entries(const Node& node, Loss loss, uint64_t seed);

  const Trace& trace_;
  Ignores ignores_;
  size_t at_ = 0;
  std::vector<Node> nodes_;
};

/// Replaces what is in the folder.
void writeImage(const std::filesystem::path& folder, const std::map<std::string, std::string>& image);
[[nodiscard]] std::map<std::string, std::string> readImage(const std::filesystem::path& folder);

}  // namespace argil::failing
