#pragma once
// One SQLite database and its statements, with the house's errors: for document_file.cpp.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace argil::io {

/// A connection that trusts nothing in the file: no code of a schema runs, limits are those of our rows, nothing is
/// mapped into memory. One thread.
class Database {
 public:
  /// The file is there (maybe empty). Messages call it `name`. What may not be written is opened for reading. Throws
  /// Error.
  Database(const std::filesystem::path& file, std::string name);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Statements without results. Throws Error.
  void run(const char* sql);
  /// The first column of the first row; 0 without one.
  int64_t number(const char* sql);
  /// Best effort, after a failure.
  void rollBack() noexcept;

  [[nodiscard]] bool inTransaction() const;
  [[nodiscard]] bool mayWrite() const;
  [[nodiscard]] sqlite3* handle() const { return handle_; }
  /// From now on failures are told as those of writing.
  void expectWriting() { writing_ = true; }
  /// The sentence for what SQLite just said; errno is still what the call left.
  [[noreturn]] void fail(int code) const;

 private:
  sqlite3* handle_ = nullptr;
  std::string name_;
  bool writing_ = false;
};

/// A prepared statement. Columns and parameters count from 0. Goes before its database does.
class Query {
 public:
  Query(Database& database, const char* sql);
  ~Query();
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  /// A number, or bytes that stay until the statement has run.
  Query& bind(int at, int64_t value);
  Query& bind(int at, std::span<const std::byte> bytes);
  Query& bind(int at, const std::string& text);
  /// True: there is a row. Throws Error, and then the statement is reset.
  bool step();
  /// As step(), but what the file's content is to blame for is `damaged` and no row.
  bool step(bool& damaged);
  /// Lets go of the row, and of the file's lock outside of a transaction.
  void reset() noexcept;

  [[nodiscard]] bool isNumber(int column) const;
  [[nodiscard]] int64_t number(int column) const;
  /// Until the next step() or reset().
  [[nodiscard]] std::span<const std::byte> bytes(int column) const;
  [[nodiscard]] std::string text(int column) const;

 private:
  Database& database_;
  sqlite3_stmt* statement_ = nullptr;
};

}  // namespace argil::io
