#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include "optim/ranks/byte_stream.h"
#include "renderer/core/parallel.h"

namespace pathfit::optim {

/// The first rank has ended what this one takes part in, and says why where people see it.
class RanksStopped : public std::runtime_error {
 public:
  RanksStopped() : std::runtime_error("ended by the first rank") {}
};

/// The processes ("ranks") that one command runs on together. The first one leads: it gives orders,
/// which all others hear in turn, and takes what they return. It alone writes files and speaks to
/// people. Called from one thread. The only door to MPI.
class Ranks {
 public:
  /// This process alone.
  Ranks();
  /// Those that an MPI launcher (mpirun, srun) has started with this process; this process alone if
  /// none has. Throws renderer::IoError if there are several and the program was built without MPI.
  Ranks(int& argc, char**& argv);
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  [[nodiscard]] int index() const { return index_; }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] bool IsFirst() const { return index_ == 0; }
  [[nodiscard]] bool IsAlone() const { return count_ == 1; }

  // Of the first rank.

  /// Gives an order to all others.
  void Tell(const Bytes& order);
  /// What a rank returned next. Throws what a rank has met instead: renderer::Cancelled,
  /// renderer::NumericalError, renderer::IoError, std::runtime_error, with its number; Cancelled,
  /// too, once the flag (may be null) is set.
  Bytes Await(int rank, const renderer::CancelFlag* cancel);
  /// Throws if a rank has met something, as Await.
  void CheckOthers();
  /// Ends what the others take part in: RanksStopped there, as soon as they look.
  void Stop();

  // Of the others.

  /// The next order. Throws RanksStopped. A flag (may be null) that is set meanwhile is the first
  /// one's to act on: it gets to know.
  Bytes Hear(const renderer::CancelFlag* cancel);
  /// Throws RanksStopped if the first rank has said so.
  void CheckFirst();
  /// Returns a result; keeps it until the first takes it, and waits while it keeps too much.
  void Return(Bytes result);
  /// Tells the first rank of the exception being handled.
  void ReportException();

  /// The end of the program, of every rank once: the status of the first is that of all. Nothing
  /// may be called afterwards.
  int End(int status);

 private:
  struct Link;
  std::unique_ptr<Link> link_;  ///< null: alone
  int index_ = 0, count_ = 1;
};

}  // namespace pathfit::optim
