#include "io/records/sqlite.h"

#include <sqlite3.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "clay/base/error.h"
#include "io/records/record.h"

namespace argil::io {

namespace {

constexpr int kBusyMilliseconds = 2000;
/// Of a row or a text; our largest is a record.
constexpr int kMostBytesOfARow = 65536;

bool contentIsToBlame(int code) {
  const int primary = code & 0xff;
  return primary == SQLITE_CORRUPT || primary == SQLITE_NOTADB || primary == SQLITE_TOOBIG || primary == SQLITE_FORMAT;
}

}  // namespace

Database::Database(const std::filesystem::path& file, std::string name) : name_(std::move(name)) {
  errno = 0;
  // Absolute: SQLite gives names like ":memory:" and "file:..." a meaning of their own.
  const int code = sqlite3_open_v2(std::filesystem::absolute(file).c_str(), &handle_,
                                   SQLITE_OPEN_READWRITE | SQLITE_OPEN_EXRESCODE | SQLITE_OPEN_NOMUTEX, nullptr);
  try {
    if (code != SQLITE_OK) fail(code);
    sqlite3_busy_timeout(handle_, kBusyMilliseconds);
    for (const auto& [option, on] : {std::pair{SQLITE_DBCONFIG_DEFENSIVE, 1},
                                     {SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0},
                                     {SQLITE_DBCONFIG_ENABLE_TRIGGER, 0},
                                     {SQLITE_DBCONFIG_ENABLE_VIEW, 0},
                                     {SQLITE_DBCONFIG_ENABLE_LOAD_EXTENSION, 0},
                                     {SQLITE_DBCONFIG_DQS_DML, 0},
                                     {SQLITE_DBCONFIG_DQS_DDL, 0}}) {
      sqlite3_db_config(handle_, option, on, nullptr);
    }
    sqlite3_limit(handle_, SQLITE_LIMIT_LENGTH, kMostBytesOfARow);
    sqlite3_limit(handle_, SQLITE_LIMIT_COLUMN, 16);
    sqlite3_limit(handle_, SQLITE_LIMIT_ATTACHED, 1);  // VACUUM INTO needs one.
    sqlite3_limit(handle_, SQLITE_LIMIT_TRIGGER_DEPTH, 1);
    // Old rows are left where they lay: recovery may find them, and writing zeros over them costs.
    run("PRAGMA mmap_size = 0; PRAGMA cell_size_check = ON; PRAGMA secure_delete = OFF; PRAGMA cache_size = -16384; "
        "PRAGMA temp_store = MEMORY");
  } catch (...) {
    sqlite3_close_v2(handle_);
    throw;
  }
}

Database::~Database() {
  sqlite3_close_v2(handle_);
}

void Database::run(const char* sql) {
  errno = 0;
  const int code = sqlite3_exec(handle_, sql, nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code);
}

int64_t Database::number(const char* sql) {
  Query query(*this, sql);
  return query.step() ? query.number(0) : 0;
}

void Database::rollBack() noexcept {
  if (inTransaction()) sqlite3_exec(handle_, "ROLLBACK", nullptr, nullptr, nullptr);
}

bool Database::inTransaction() const {
  return sqlite3_get_autocommit(handle_) == 0;
}

bool Database::mayWrite() const {
  return sqlite3_db_readonly(handle_, "main") == 0;
}

void Database::fail(int code) const {
  const int primary = code & 0xff;
  // sqlite3_system_errno() knows nothing of a commit that failed. ENOENT is left by looking for files that need not be
  // there.
  const bool ofTheSystem = (primary == SQLITE_IOERR || primary == SQLITE_CANTOPEN) && errno != ENOENT;
  const int systemError = ofTheSystem ? errno : 0;
  const auto because = [&](const std::string& otherwise) {
    return " (" + (systemError != 0 ? std::generic_category().message(systemError) : otherwise) + ")";
  };
  const std::string save = name_ + ": cannot be saved";
  if (contentIsToBlame(code))
    throw Error(name_ + ": is damaged (" + sqlite3_errstr(code) +
                    "); recover what is whole in it and save that under another name",
                writing_ ? Error::Kind::work : Error::Kind::input);
  if (primary == SQLITE_BUSY || primary == SQLITE_LOCKED)
    throw Error(name_ + ": is in use by another program; try again when that is done", Error::Kind::work);
  if (primary == SQLITE_NOMEM)
    throw Error(name_ + ": there is not enough memory for it; close something", Error::Kind::work);
  if (primary == SQLITE_FULL)
    throw Error(save + because("no space left on device") + "; make room or save it elsewhere", Error::Kind::work);
  if (writing_)
    throw Error(save + because(sqlite3_errstr(code)) + "; save it under another name or elsewhere", Error::Kind::work);
  throw Error(name_ + ": cannot be read" + because(sqlite3_errstr(code)) + "; check the disk and the permissions");
}

Query::Query(Database& database, const char* sql) : database_(database) {
  errno = 0;
  const int code = sqlite3_prepare_v3(database.handle(), sql, -1, SQLITE_PREPARE_PERSISTENT, &statement_, nullptr);
  if (code != SQLITE_OK) database.fail(code);
}

Query::~Query() {
  sqlite3_finalize(statement_);
}

Query& Query::bind(int at, int64_t value) {
  sqlite3_bind_int64(statement_, at + 1, value);
  return *this;
}

Query& Query::bind(int at, std::span<const std::byte> bytes) {
  sqlite3_bind_blob(statement_, at + 1, bytes.data(), static_cast<int>(bytes.size()), SQLITE_STATIC);
  return *this;
}

Query& Query::bind(int at, const std::string& text) {
  sqlite3_bind_text(statement_, at + 1, text.c_str(), static_cast<int>(text.size()), SQLITE_STATIC);
  return *this;
}

bool Query::step() {
  errno = 0;
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  try {
    database_.fail(code);
  } catch (...) {
    reset();
    throw;
  }
}

bool Query::step(bool& damaged) {
  errno = 0;
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  damaged = contentIsToBlame(code) || (code & 0xff) == SQLITE_IOERR;
  if (damaged) {
    reset();
    return false;
  }
  try {
    database_.fail(code);
  } catch (...) {
    reset();
    throw;
  }
}

void Query::reset() noexcept {
  sqlite3_reset(statement_);
}

bool Query::isNumber(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_INTEGER;
}

int64_t Query::number(int column) const {
  return sqlite3_column_int64(statement_, column);
}

std::span<const std::byte> Query::bytes(int column) const {
  const auto* data = static_cast<const std::byte*>(sqlite3_column_blob(statement_, column));
  return {data, static_cast<size_t>(sqlite3_column_bytes(statement_, column))};
}

std::string Query::text(int column) const {
  const auto* text = sqlite3_column_text(statement_, column);
  return text == nullptr ? std::string()
                         : std::string(reinterpret_cast<const char*>(text),
                                       static_cast<size_t>(sqlite3_column_bytes(statement_, column)));
}

}  // namespace argil::io
