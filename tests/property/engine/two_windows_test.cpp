// Two and three windows on the same few files, in any order of save, save as, open and kill, while other programs copy,
// put back and remove files: every file always holds what the window had that saved it last, every step of it too, and
// a crash loses nothing.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <map>
#include <string>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/document/random.h"
#include "engine/saving/autosave.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "engine/session/recovery.h"
#include "engine/text/document_text.h"
#include "tests/support/tier.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;

// All that a document is, clay by its hash.
std::string told(const Document& document) {
  std::vector<ClayKey> clay;
  for (const Piece& piece : document.pieces) clay.push_back({piece.version.hash() >> 12, 0});
  return documentText(document, clay, {});
}

// What each state of any document was when it was made, by the label of the state: labels are unique in this test.
class Truth {
 public:
  std::string next() { return "step " + std::to_string(++count_); }
  void add(const std::string& label, const Document& document) { all_[label] = told(document); }
  [[nodiscard]] bool holds(const std::string& label, const Document& document) const {
    const auto found = all_.find(label);
    return found != all_.end() && found->second == told(document);
  }

 private:
  size_t count_ = 0;
  std::map<std::string, std::string> all_;
};

// A file as it ought to be. Copies of one save are alike.
struct OnDisk {
  uint64_t token = 0;
  std::string newest;  // label
};

// One window: what a workbench does with files, without its threads.
class Window {
 public:
  Window(fs::path journals, Truth& truth) : journals_(std::move(journals)), truth_(truth) {}
  ~Window() {
    if (session_) session_->setWatch(nullptr);
  }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  void beginNew(Random& random) {
    clay::Grid grid;
    grid.voxelMm = 0.5;
    // All stand in the same place, so that a brick of one would fit into another.
    Document first = Document::of(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 3 + 2 * random.unit()));
    const std::string label = truth_.next();
    truth_.add(label, first);
    Begin how;
    how.states = {{.label = label, .document = std::make_shared<const Document>(std::move(first))}};
    how.documentRecords = std::make_shared<DocumentRecords>();
    begin(std::move(how));
  }

  void open(const fs::path& path, uint64_t itsToken) {
    OpenedDocument opened = openDocument(path);
    Begin how;
    how.states = std::move(opened.states);
    how.done = opened.done;
    how.documentRecords = std::move(opened.documentRecords);
    how.base = std::move(opened.base);
    how.file = path;
    how.token = itsToken;
    begin(std::move(how));
    saved_ = now();
  }

  void edit(Random& random) {
    const std::string label = truth_.next();
    session_->change(label, [&](Document& document) {
      Session stroke(document.pieces[0].version);
      Tool tool;
      tool.radiusMm = 1.5;
      tool.id = random.below(2) == 0 ? "carve" : "add";
      stroke.beginStroke(tool);
      Vec3d at = 4 * random.inBall().normalized();
      for (int i = 0; i < 3; ++i, at += 0.8 * random.inBall()) stroke.addPoint(0.001 * i, at);
      document.pieces[0].version = stroke.endStroke();
    });
    truth_.add(label, *session_->document());
  }

  // A step that nobody can read any more is allowed where its file is another's by now; one that is read is what it
  // was.
  void goSomewhere(Random& random, uint64_t& reads, uint64_t& lost) {
    try {
      session_->goTo(random.below(session_->states().size()));
      ++reads;
    } catch (const Error&) {
      ++lost;
    }
    expectTrue();
  }

  void save(const fs::path& path) {
    SaveRequest request;
    request.states = session_->states();
    request.done = session_->undoSteps();
    request.documentRecords = documentRecords_;
    request.base = base_;
    request.sources = {records_};
    request.writer = writer_;
    autosave_->saving(path);
    try {
      base_ = saveDocument(path, request);
    } catch (const Error&) {
      autosave_->saving({});
      throw;
    }
    file_ = path;
    saved_ = now();
    autosave_->saved(base_);
  }

  // Its journal is all that is left.
  void kill() {
    autosave_->flush();
    session_->setWatch(nullptr);
    autosave_->leave();
    autosave_.reset();
    dead_ = true;
    killed_ = now();
  }

  void comeBack(Random& random, const std::map<fs::path, OnDisk>& files) {
    dead_ = false;
    const bool unsaved = killed_ != saved_;
    const std::string wanted = killed_;
    const std::vector<Recoverable> found = recoverable(journals_);
    EXPECT_TRUE(found.size() == 1 || !certain || !unsaved) << "work is lost";
    for (const Recoverable& each : found) {
      try {
        Recovered recovered = recover(each.journal);
        ASSERT_TRUE(recovered.strokes.empty());
        Begin how;
        OpenedDocument& document = recovered.document;
        how.states = std::move(document.states);
        how.done = document.done;
        how.documentRecords = std::move(document.documentRecords);
        how.base = std::move(document.base);
        how.writer = recovered.writer;
        how.sources = std::move(recovered.sources);
        how.continued = std::move(recovered.continued);
        if (how.base) {
          how.file = how.base->path;
          how.token = files.at(how.file).token;
        }
        const std::string before = saved_;
        begin(std::move(how));
        saved_ = before;
        expectTrue();
        EXPECT_EQ(now(), wanted) << "recovered is not what there was";
        ++recoveries;
        return;
      } catch (const Error& e) {
        EXPECT_FALSE(certain) << e.what();
        fs::remove(each.journal);
      }
    }
    beginNew(random);
  }

  void expectTrue() const { EXPECT_TRUE(truth_.holds(now(), *session_->document())) << now() << " is not what it was"; }

  [[nodiscard]] const std::string& now() const { return session_->states()[session_->undoSteps()].label; }
  [[nodiscard]] const fs::path& file() const { return file_; }
  [[nodiscard]] bool dead() const { return dead_; }

  uint64_t token = 0;   // of the save that it read or made last
  bool certain = true;  // while it is dead: nobody wrote to its file since
  static inline uint64_t recoveries = 0;

 private:
  struct Begin {
    std::vector<HistoryState> states;
    size_t done = 0;
    fs::path file;
    std::shared_ptr<DocumentRecords> documentRecords;
    std::shared_ptr<const Base> base;
    std::string writer;
    std::vector<std::shared_ptr<io::RecordSource>> sources;
    std::optional<Autosave::Continued> continued;
    uint64_t token = 0;
  };
  void begin(Begin how) {
    if (session_) session_->setWatch(nullptr);
    file_ = std::move(how.file);
    documentRecords_ = std::move(how.documentRecords);
    base_ = std::move(how.base);
    token = how.token;
    writer_ = how.writer.empty() ? newWriter() : how.writer;
    saved_.clear();
    if (!autosave_) {
      AutosaveOptions options;
      options.folder = journals_;
      options.syncS = 0.0001;
      autosave_ = std::make_unique<Autosave>(options, [](const std::string& trouble) { EXPECT_EQ(trouble, ""); });
    }
    records_ =
        autosave_->begin(how.states, how.done, documentRecords_, base_, writer_, std::move(how.continued), how.sources);
    session_ = std::make_unique<Session>(std::move(how.states), how.done);
    session_->setWatch(autosave_.get());
    session_->setReader([this](uint64_t kept, const Document& near) {
      return readStep(*autosave_, *documentRecords_, records_, kept, near);
    });
  }

  const fs::path journals_;
  Truth& truth_;
  std::unique_ptr<Autosave> autosave_;
  std::shared_ptr<DocumentRecords> documentRecords_;
  std::shared_ptr<const Base> base_;
  std::shared_ptr<SavedHistory> records_;
  std::string writer_;
  std::unique_ptr<Session> session_;
  fs::path file_;
  std::string saved_, killed_;  // labels
  bool dead_ = false;
};

struct Tally {
  uint64_t saves = 0, refused = 0, reads = 0, lost = 0, copies = 0;
};

class Interleaving {
 public:
  Interleaving(const fs::path& folder, uint64_t seed, Tally& tally) : folder_(folder), random_(seed), tally_(tally) {
    fs::remove_all(folder);
    fs::create_directories(folder);
    for (size_t i = 0; i < 2 + seed % 2; ++i) {
      windows_.push_back(std::make_unique<Window>(folder / ("journals" + std::to_string(i)), truth_));
      windows_.back()->beginNew(random_);
    }
  }

  void run(int steps) {
    for (int i = 0; i < steps && !testing::Test::HasFailure(); ++i) {
      step();
      expectFilesTrue();
      if (testing::Test::HasFailure()) std::printf("  what happened:\n%s", story_.c_str());
    }
  }

 private:
  fs::path path() { return folder_ / (std::string(1, static_cast<char>('a' + random_.below(3))) + ".argil"); }

  void step() {
    const size_t who = random_.below(windows_.size());
    Window& window = *windows_[who];
    const auto tell = [&](const std::string& what) {
      story_ += "    window " + std::to_string(who) + ": " + what + "\n";
    };
    if (window.dead()) {
      tell("recovers");
      window.comeBack(random_, files_);
      return;
    }
    switch (random_.below(16)) {
      case 0:
      case 1:
      case 2:
      case 3:
        window.edit(random_);
        tell("makes " + window.now());
        break;
      case 4:
        window.goSomewhere(random_, tally_.reads, tally_.lost);
        tell("goes to " + window.now());
        break;
      case 5:
      case 6:
      case 7:
      case 8:
        if (window.file().empty()) break;
        tell("saves " + window.now() + " to " + window.file().filename().string());
        save(window, window.file());
        break;
      case 9:
      case 10: {
        const fs::path to = path();
        tell("saves " + window.now() + " as " + to.filename().string());
        save(window, to);
        break;
      }
      case 11:
      case 12: {
        const fs::path from = path();
        if (!files_.contains(from)) break;
        tell("opens " + from.filename().string());
        window.open(from, files_[from].token);
        window.expectTrue();
        break;
      }
      case 13:
      case 14:
        tell("is killed at " + window.now());
        window.kill();
        window.certain = true;
        break;
      default:
        anotherProgram();
    }
  }

  // Writes into its own file only while that is what it read or wrote last; under another name always.
  void save(Window& window, const fs::path& to) {
    const bool own = to == window.file();
    const auto there = files_.find(to);
    const bool may = !own || there == files_.end() || there->second.token == window.token;
    try {
      window.save(to);
      EXPECT_TRUE(may) << to << ": a save went into a file that somebody else wrote";
      ++tally_.saves;
      window.token = ++tokens_;
      files_[to] = {window.token, window.now()};
      changed(to, &window);
    } catch (const Error& e) {
      EXPECT_FALSE(may) << e.what();
      EXPECT_NE(std::string(e.what()).find("another name"), std::string::npos) << e.what();
      ++tally_.refused;
    }
  }

  // A sync program, a backup, a person with a file manager.
  void anotherProgram() {
    const fs::path from = path(), to = path(), kept = folder_ / "kept";
    const auto there = files_.find(from);
    const uint64_t what = random_.below(5);
    ++tally_.copies;
    if (what == 0) {
      story_ += "    another program removes " + from.filename().string() + "\n";
      fs::remove(from);
      files_.erase(from);
      changed(from, nullptr);
    } else if (what == 1) {
      if (there == files_.end()) return;
      story_ += "    another program keeps a copy of " + from.filename().string() + "\n";
      fs::copy_file(from, kept, fs::copy_options::overwrite_existing);
      backup_ = there->second;
    } else if (what == 2) {
      if (backup_.token == 0) return;
      story_ += "    another program puts the copy back as " + to.filename().string() + "\n";
      fs::copy_file(kept, folder_ / "new", fs::copy_options::overwrite_existing);
      fs::rename(folder_ / "new", to);
      files_[to] = backup_;
      changed(to, nullptr);
    } else if (there != files_.end() && from != to) {
      story_ += "    another program copies " + from.filename().string() + (what == 3 ? " over " : " into ") +
                to.filename().string() + "\n";
      // Over it by a new file that takes its name, or into it, byte by byte.
      if (what == 3) {
        fs::copy_file(from, folder_ / "new", fs::copy_options::overwrite_existing);
        fs::rename(folder_ / "new", to);
      } else {
        fs::copy_file(from, to, fs::copy_options::overwrite_existing);
      }
      files_[to] = there->second;
      changed(to, nullptr);
    }
  }

  void changed(const fs::path& path, const Window* by) {
    for (const auto& window : windows_) {
      if (window.get() != by && window->file() == path && window->dead()) window->certain = false;
    }
  }

  void expectFilesTrue() {
    for (const auto& [path, wanted] : files_) {
      const OpenedDocument opened = openDocument(path);
      EXPECT_TRUE(opened.notes.empty()) << path << ": " << opened.notes[0];
      const HistoryState& newest = opened.states.at(opened.done);
      EXPECT_EQ(newest.label, wanted.newest) << path << " does not hold what was saved last";
      EXPECT_TRUE(truth_.holds(newest.label, *newest.document)) << path << " holds clay that nobody made";
      const HistoryState& other = opened.states[random_.below(opened.states.size())];
      const DocumentPtr step = readState(*opened.documentRecords, opened.base, {}, other.kept, *newest.document);
      EXPECT_TRUE(truth_.holds(other.label, *step)) << path << ": its " << other.label << " is not what was made";
    }
  }

  const fs::path folder_;
  Random random_;
  Tally& tally_;
  Truth truth_;
  std::vector<std::unique_ptr<Window>> windows_;
  std::map<fs::path, OnDisk> files_;
  OnDisk backup_;
  uint64_t tokens_ = 0;
  std::string story_;
};

// 1000 of them in the long tier.
TEST(TwoWindows, NeitherDocumentEverHoldsTheOthersClay) {
  const uint64_t rounds = tests::byTier(60, 1000);
  // Where nothing has to wait for a disk, if there is such a place.
  const fs::path shared = "/dev/shm";
  const fs::path folder = (::access(shared.c_str(), W_OK) == 0 ? shared : fs::temp_directory_path()) /
                          ("argil-two-windows-" + std::to_string(::getpid()));
  Tally tally;
  for (uint64_t seed = 1; seed <= rounds && !HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Interleaving(folder, seed, tally).run(30);
  }
  fs::remove_all(folder);
  std::printf(
      "  %llu interleavings: %llu saves, %llu refused, %llu recoveries, %llu steps read again, %llu that no file holds "
      "any more\n",
      static_cast<unsigned long long>(rounds), static_cast<unsigned long long>(tally.saves),
      static_cast<unsigned long long>(tally.refused), static_cast<unsigned long long>(Window::recoveries),
      static_cast<unsigned long long>(tally.reads), static_cast<unsigned long long>(tally.lost));
  EXPECT_GT(tally.saves, rounds);
  EXPECT_GT(tally.refused, rounds / 10);
  EXPECT_GT(Window::recoveries, rounds / 2);
  EXPECT_GT(tally.reads, 10 * tally.lost);
}

}  // namespace
}  // namespace argil::engine
