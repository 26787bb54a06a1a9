// A disk that fails once while a recovered document gets a journal of its own.

#include <gtest/gtest.h>

#include <cerrno>
#include <thread>

#include "engine/session/recovery.h"
#include "tests/support/failing_writes.h"
#include "tests/unit/engine/saving_rig.h"

namespace argil::engine {
namespace {

using FailingJournal = SavingRig;

// Whichever call fails: the journal that was recovered stays until the new one is on the disk, and no longer.
TEST_F(FailingJournal, TheRecoveredOneGoesOnceTheNewOneIsOnTheDisk) {
  const fs::path crashed = folder / "crashed.journal";
  {
    Kept kept(fullDocument(), folder / "before");
    kept.folder = folder / "before";
    stroke(kept.session, 1);
    kept.crash(crashed);
  }
  int failures = 0;
  for (long call = 1; call <= 24; ++call) {
    SCOPED_TRACE(call);
    const fs::path journals = folder / ("journals" + std::to_string(call)), old = journals / "1.journal";
    fs::create_directories(journals);
    fs::copy_file(crashed, old);
    Recovered recovered = recover(old);
    AutosaveOptions options;
    options.folder = journals;
    options.syncS = 0.001;
    options.retryS = options.mostRetryS = 0.01;
    std::string wanted;
    {
      Autosave autosave(options, [](const std::string&) {});
      Session session(recovered.document.states, recovered.document.done);
      failing::begin({.error = EIO, .from = call, .once = true, .pathPart = journals.c_str()});
      autosave.begin(recovered.document.states, recovered.document.done, recovered.document.documentRecords, nullptr,
                     recovered.writer, std::move(recovered.continued));
      session.setWatch(&autosave);
      autosave.flush();  // Or a busy machine writes the beginning and the stroke at once, in fewer calls.
      stroke(session, 77);
      autosave.flush();
      const long calls = failing::end();
      failures += calls >= call;
      for (int i = 0; i < 10'000 && fs::exists(old); ++i) {
        autosave.flush();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      EXPECT_FALSE(fs::exists(old));
      wanted = SavingRig::told(*session.document());
      session.setWatch(nullptr);
      autosave.leave();
    }
    const std::vector<Recoverable> found = recoverable(journals);
    ASSERT_EQ(found.size(), 1u);
    Recovered again = recover(found[0].journal);
    EXPECT_EQ(SavingRig::told(*again.document.states[again.document.done].document), wanted);
    fs::remove_all(journals);
  }
  std::printf("%d calls failed\n", failures);
  EXPECT_GT(failures, 5);
}

}  // namespace
}  // namespace argil::engine
