#include "io/records/document_facts.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cinttypes>
#include <climits>
#include <cstdio>

#include "io/bytes/input.h"
#include "io/records/document_file.h"

namespace argil::io {

namespace {

constexpr const char* kMetaTable = "CREATE TABLE meta(key TEXT PRIMARY KEY, value) WITHOUT ROWID";
constexpr const char* kRecordTable =
    "CREATE TABLE record(id INTEGER PRIMARY KEY, kind INTEGER NOT NULL, body BLOB NOT NULL)";
constexpr int kMostMetaRows = 64;
constexpr size_t kMostVersionShown = 40;

/// Over all rows but that of the checksum itself.
int64_t checksumOfMeta(Database& database, const std::string& name) {
  Query all(database, "SELECT key, value FROM meta WHERE key <> 'check' ORDER BY key");
  uint64_t sum = 0;
  for (int rows = 0; all.step(); ++rows) {
    if (rows == kMostMetaRows) failDamaged(name, "its table of facts is too long");
    const std::string row = all.text(0) + (all.isNumber(1) ? "\1" : "\2") + all.text(1);
    sum = XXH3_64bits_withSeed(row.data(), row.size(), sum);
  }
  return static_cast<int64_t>(sum >> 1);
}

int64_t metaNumber(Database& database, const char* key, const std::string& name) {
  Query one(database, "SELECT value FROM meta WHERE key = ?1");
  const std::string text = key;
  one.bind(0, text);
  if (!one.step() || !one.isNumber(0) || one.number(0) < 0) failDamaged(name, "its table of facts lacks " + text);
  return one.number(0);
}

/// Empty without such a row: files of before have no lineage.
std::string metaText(Database& database, const std::string& key) {
  Query one(database, "SELECT value FROM meta WHERE key = ?1");
  one.bind(0, key);
  return one.step() ? one.text(0) : std::string();
}

/// "stamp:nextId stamp:nextId ...", hexadecimal. A row of the table of facts, because Argils of before read over rows
/// that they do not know.
std::string lineageText(const Lineage& lineage) {
  std::string text;
  char one[40];
  for (const SavePoint& point : lineage) {
    std::snprintf(one, sizeof one, "%" PRIx64 ":%" PRIx64 " ", point.stamp, point.nextId);
    text += one;
  }
  return text;
}

Lineage readLineage(const std::string& text, const std::string& name) {
  Lineage lineage;
  for (size_t at = 0; at < text.size();) {
    SavePoint point;
    int length = 0;
    const int found =
        std::sscanf(text.c_str() + at, "%16" SCNx64 ":%16" SCNx64 " %n", &point.stamp, &point.nextId, &length);
    if (found != 2 || length == 0 || point.stamp == 0 || point.nextId > kMostIds || lineage.size() >= kMostLineage)
      failDamaged(name, "its lineage cannot be read");
    lineage.push_back(point);
    at += static_cast<size_t>(length);
  }
  return lineage;
}

}  // namespace

RecordId sharedWith(const DocumentFacts& facts, uint64_t stamp) {
  if (facts.save == 0 || stamp == 0) return 0;
  if (stamp == facts.stamp) return facts.nextId;
  for (const SavePoint& point : facts.lineage) {
    if (point.stamp == stamp) return point.nextId;
  }
  return 0;
}

void failDamaged(const std::string& name, const std::string& what) {
  fail(name, "is damaged (" + what + "); recover what is whole in it and save that under another name");
}

void makeTables(Database& database) {
  database.run(("PRAGMA application_id = " + std::to_string(kDocumentApplicationId)).c_str());
  database.run(kMetaTable);
  database.run(kRecordTable);
}

void writeFacts(Database& database, const DocumentFacts& facts, const std::string& name) {
  Query put(database, "INSERT OR REPLACE INTO meta(key, value) VALUES(?1, ?2)");
  const auto set = [&](const char* key, int64_t value) {
    const std::string text = key;
    put.bind(0, text).bind(1, value).step();
    put.reset();
  };
  set("schema", std::max(facts.schema, kDocumentSchema));
  set("needs", facts.needs);
  set("save", static_cast<int64_t>(facts.save));
  set("stamp", static_cast<int64_t>(facts.stamp));
  set("head", static_cast<int64_t>(facts.head));
  set("next_id", static_cast<int64_t>(facts.nextId));
  if (database.number("PRAGMA user_version") < facts.needs)
    database.run(("PRAGMA user_version = " + std::to_string(facts.needs)).c_str());
  const auto setText = [&](const std::string& key, const std::string& value) {
    put.bind(0, key).bind(1, value).step();
    put.reset();
  };
  setText("written_by", ARGIL_VERSION);
  setText("lineage", lineageText(facts.lineage));
  set("check", checksumOfMeta(database, name));
}

DocumentFacts readFacts(Database& database, const std::string& name) {
  if (metaNumber(database, "check", name) != checksumOfMeta(database, name))
    failDamaged(name, "its table of facts has changed");
  DocumentFacts facts;
  facts.save = static_cast<uint64_t>(metaNumber(database, "save", name));
  facts.stamp = static_cast<uint64_t>(metaNumber(database, "stamp", name));
  facts.head = static_cast<RecordId>(metaNumber(database, "head", name));
  facts.nextId = static_cast<RecordId>(metaNumber(database, "next_id", name));
  facts.needs = static_cast<int>(metaNumber(database, "needs", name));
  facts.schema = static_cast<int>(std::min<int64_t>(metaNumber(database, "schema", name), INT_MAX));
  facts.writtenBy = displayName(metaText(database, "written_by").substr(0, kMostVersionShown));
  facts.lineage = readLineage(metaText(database, "lineage"), name);
  if (facts.stamp == 0) failDamaged(name, "its last save has no stamp");
  if (facts.nextId == 0 || facts.nextId > kMostIds || facts.head >= facts.nextId)
    failDamaged(name, "its ids are out of range");
  return facts;
}

// Exactly our two tables: whatever else a schema can hold (views, triggers, indices, generated columns, checks) is
// code.
void checkTables(Database& database, const std::string& name) {
  const int64_t version = database.number("PRAGMA user_version");
  int ours = 0, others = 0;
  {
    Query all(database, "SELECT type, name, sql FROM sqlite_schema LIMIT 8");
    while (all.step()) {
      const std::string table = all.text(1), sql = all.text(2);
      const bool known = all.text(0) == "table" &&
                         ((table == "meta" && sql == kMetaTable) || (table == "record" && sql == kRecordTable));
      (known ? ours : others) += 1;
    }
  }
  Query meta(database, "SELECT 1 FROM sqlite_schema WHERE type = 'table' AND name = 'meta' AND sql = ?1");
  const std::string sql = kMetaTable;
  const bool mayAsk = meta.bind(0, sql).step();
  meta.reset();
  // The table of facts stays as it is in all schemas, so that every Argil can tell which one a file needs.
  if (mayAsk && metaNumber(database, "needs", name) > kDocumentSchema) {
    const std::string by = metaText(database, "written_by").substr(0, kMostVersionShown);
    const std::string who = by.empty() ? "of a later date" : displayName(by);
    fail(name, "was written by Argil " + who + " and needs at least that to be read; nothing was opened");
  }
  if (ours == 2 && others == 0) return;
  if (version > kDocumentSchema)
    fail(name, "was written by a newer Argil and needs that to be read; nothing was opened");
  failDamaged(name, "its tables are not those of a document");
}

}  // namespace argil::io
