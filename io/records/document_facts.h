#pragma once
// What stands in a document beside its records: for document_file.cpp.

#include <cstdint>
#include <filesystem>
#include <string>

#include "io/records/document_file.h"
#include "io/records/record.h"
#include "io/records/sqlite.h"

namespace argil::io {

inline constexpr uint32_t kDocumentApplicationId = 0x41726744;  // "ArgD"
/// Sets of ids are bits: a file that claims more would cost a GiB. A stroke takes about a thousand.
inline constexpr RecordId kMostIds = RecordId{1} << 33;

/// What a commit leaves in the table `meta`.
struct DocumentFacts {
  uint64_t save = 0;
  uint64_t stamp = 0;  ///< Random, so that two saves of one count are told apart.
  RecordId head = 0;
  RecordId nextId = 1;
  int needs = 1;          ///< The least schema that knows all kinds of its records.
  int schema = 0;         ///< The highest of its writers; what is written has this program's at least.
  std::string writtenBy;  ///< Read, never written: that is this program's version.
  Lineage lineage;        ///< The saves before this one.
};

/// See DocumentFile::sharedWith().
[[nodiscard]] RecordId sharedWith(const DocumentFacts& facts, uint64_t stamp);

/// All of these throw Error; `name` is that of the file in messages.
void makeTables(Database& database);
/// Refuses a file that needs a later Argil, and one with anything but our two tables in it.
void checkTables(Database& database, const std::string& name);
void writeFacts(Database& database, const DocumentFacts& facts, const std::string& name);
/// Refuses facts that are not what was written, by their checksum.
[[nodiscard]] DocumentFacts readFacts(Database& database, const std::string& name);

[[noreturn]] void failDamaged(const std::string& name, const std::string& what);

/// Throws Error, which names the file, for what is no document that can be read.
void checkFile(const std::filesystem::path& path, const std::string& name);

}  // namespace argil::io
