#pragma once
// Whether the open document may be put away: the question, the name, the save, and only then what was asked for.

#include <filesystem>
#include <optional>

#include "engine/session/workbench.h"

namespace argil::studio {

/// What the person asked for that puts the open document away.
struct Departure {
  enum class To : uint8_t { quit, newDocument, file, recovered };
  To to = To::quit;
  std::filesystem::path file = {};                              ///< Of To::file,
  std::optional<engine::Workbench::ImportOptions> import = {};  ///< read like this where its format says too little.
  std::optional<engine::Recoverable> what = {};                 ///< Of To::recovered,
  engine::RecoverChoice how = {};                               ///< and how.
};

/// A state machine: it is told what the person and the workbench did and says what comes next. Knows no window. One
/// thread.
class SaveFlow {
 public:
  enum class Stage : uint8_t {
    idle,    ///< Nobody has asked for anything.
    asking,  ///< Save, don't save, cancel: the question stands.
    naming,  ///< The document has no file yet, or one into which it cannot be saved: a name is being chosen.
    saving,
  };
  enum class Answer : uint8_t { save, dontSave, cancel };
  /// What whoever runs it has to do now.
  enum class Next : uint8_t { nothing, chooseName, save, go };

  /// Something is worth asking: work that its file does not hold. A model that was opened and only looked at is
  /// nobody's work.
  [[nodiscard]] static bool unkept(const engine::Snapshot& now);

  /// Go at once where nothing is lost, else the question. Asked again meanwhile, the newer wish takes the older one's
  /// place.
  Next want(Departure departure, const engine::Snapshot& now);
  Next answer(Answer answer, const engine::FileState& file);
  /// A name was chosen, and saving to it was asked for; or the dialog was closed without one.
  void named();
  void notNamed();
  /// Once a frame. `underWay`: the save was not begun yet, or the workbench is not idle, looked up before `file` was.
  /// Go once the file holds the document; chooseName where it cannot be saved into its file. When nothing is under way
  /// for kFailedS and it does not, saving has failed (the workbench says why): idle again.
  Next follow(const engine::FileState& file, bool underWay, double timeS);
  /// The person would rather stay; a save that runs goes on.
  void stay();

  [[nodiscard]] Stage stage() const { return stage_; }
  [[nodiscard]] const Departure& departure() const { return departure_; }

  /// Between two looks the edit thread may be just about to say that it works.
  static constexpr double kFailedS = 0.3;

 private:
  Stage stage_ = Stage::idle;
  Departure departure_;
  uint64_t refusedBefore_ = 0;  // Of its file, when the save was asked for.
  double restingSinceS_ = -1;   // Negative: something is under way.
};

}  // namespace argil::studio
