//! Forks: rayon's parallel iterators and joins, told to the recorder.

use rayon::prelude::*;

use super::disturb;
use super::record::{begin_task, close_even, close_fork, cut, end_task, is_on, open_fork};

/// A fork while its tasks run. Where none of the functions below fits, a parallel iterator wraps what it does for
/// an item in [`Fork::task`]; the fork ends when this is dropped.
#[derive(Debug)]
pub struct Fork {
    recorded: bool,
}

impl Fork {
    /// Open a fork.
    pub fn open(name: &'static str) -> Self {
        let recorded = is_on();
        if recorded {
            open_fork(name);
        }
        Self { recorded }
    }

    /// One of its tasks.
    pub fn task<R>(&self, work: impl FnOnce() -> R) -> R {
        if !self.recorded {
            let made = work();
            disturb::ended();
            return made;
        }
        begin_task();
        let made = work();
        end_task();
        made
    }
}

impl Drop for Fork {
    fn drop(&mut self) {
        if self.recorded {
            close_fork();
        }
    }
}

/// `work` of each item, a task each; in the order of the items.
pub fn map<I, R: Send>(
    name: &'static str,
    items: I,
    work: impl Fn(I::Item) -> R + Send + Sync,
) -> Vec<R>
where
    I: IntoParallelIterator<Iter: IndexedParallelIterator>,
{
    let fork = Fork::open(name);
    items.into_par_iter().with_max_len(1).map(|item| fork.task(|| work(item))).collect()
}

/// Like [`map`]; the largest are begun first, for what is begun last is what the others wait for.
pub fn map_by_size<T: Send, R: Send>(
    name: &'static str,
    items: Vec<T>,
    size: impl Fn(&T) -> usize,
    work: impl Fn(T) -> R + Send + Sync,
) -> Vec<R> {
    let fork = Fork::open(name);
    let mut made: Vec<Option<R>> = items.iter().map(|_| None).collect();
    let mut tasks: Vec<(&mut Option<R>, T)> = made.iter_mut().zip(items).collect();
    tasks.sort_by_key(|(_, item)| std::cmp::Reverse(size(item)));
    rayon::in_place_scope_fifo(|scope| {
        for (place, item) in tasks {
            let (fork, work) = (&fork, &work);
            scope.spawn_fifo(move |_| *place = Some(fork.task(|| work(item))));
        }
    });
    made.into_iter().flatten().collect()
}

/// Both at the same time.
pub fn join<A: Send, B: Send>(
    name: &'static str,
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    let fork = Fork::open(name);
    rayon::join(|| fork.task(a), || fork.task(b))
}

/// Work that rayon divides among threads into as many tasks as there are `items`, all about as long.
pub fn even<R>(name: &'static str, items: usize, work: impl FnOnce() -> R) -> R {
    if !is_on() {
        return work();
    }
    cut();
    let made = work();
    close_even(name, items);
    made
}
