#pragma once
// Choosing a file or a folder, or where a file is to be.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace argil::studio {

/// A dialog of its own: folders, files of some endings, a name that can be typed.
class FileDialog {
 public:
  struct Request {
    std::string title, verb;           ///< "Open a document", "Open".
    std::vector<std::string> endings;  ///< ".stl" and so on, small letters; empty: folders are chosen.
    std::string where = {};            ///< Folder to begin in; empty: where the last one was, or the person's home.
    /// The file need not be there: the first ending is added to a name without one, another file is replaced after a
    /// question.
    bool toWrite = false;
    std::string name = {};  ///< That is typed already.
    std::string note = {};  ///< Why it is asked for, a sentence; empty: the title says it.
  };
  void open(Request request);
  void close() { open_ = false; }
  [[nodiscard]] bool isOpen() const { return open_; }

  /// Draws it where it is open, once a frame; `more` draws what else is to be chosen, above the buttons, `moreHeight`
  /// high. True in the one frame in which a file was chosen: path() names it.
  bool draw(const std::function<void()>& more = {}, float moreHeight = 0);
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// As it is typed or clicked so far.
  [[nodiscard]] const std::string& typed() const { return typed_; }

 private:
  struct Entry {
    std::string name;
    bool folder = false;
    uint64_t bytes = 0;
  };
  void go(const std::filesystem::path& folder);
  void list();
  int moveMark();
  bool chooses(const std::string& typed);
  bool writes(std::filesystem::path whole);

  Request request_;
  bool open_ = false;
  std::filesystem::path folder_, path_;
  std::string folderText_, typed_, problem_;
  std::filesystem::path replacing_;  // Asked about: there already.
  std::vector<Entry> entries_;
  int chosen_ = -1;
  bool marked_ = false;  // By arrows: Enter opens it, not what is typed.
};

}  // namespace argil::studio
