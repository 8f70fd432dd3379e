// Workers with a wasm instance each, and jobs for them.

// What a job gives that was dropped before a worker took it.
export const DROPPED = Symbol('dropped');

// A worker, as a function from jobs to promises.
class Hand {
  constructor(module, onprogress) {
    this.worker = new Worker(new URL('worker.js', import.meta.url), { type: 'module' });
    this.waiting = new Map();
    this.count = 0;
    this.worker.onmessage = ({ data }) => {
      if (data.progress) return onprogress?.(...data.progress);
      const { resolve, reject } = this.waiting.get(data.id);
      this.waiting.delete(data.id);
      if (data.error === undefined) resolve(data.result);
      else reject(Object.assign(new Error(data.error), { fatal: data.fatal }));
    };
    this.worker.onerror = (event) => this.end(new Error(event.message || 'a worker could not be started'));
    this.ready = this.run({ job: 'init', module });
  }

  run(job, transfer = []) {
    const id = this.count++;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.worker.postMessage({ id, ...job }, transfer);
    });
  }

  end(error = new Error('cancelled')) {
    this.worker.terminate();
    this.waiting.forEach(({ reject }) => reject(error));
    this.waiting.clear();
  }
}

// Runs one job on a worker of its own, which takes its memory with it when it ends. `signal` ends it before that.
export async function alone(module, job, { signal, onprogress, transfer }) {
  signal?.throwIfAborted();
  const hand = new Hand(module, onprogress);
  const end = () => hand.end(signal.reason);
  signal?.addEventListener('abort', end, { once: true });
  try {
    await hand.ready;
    return await hand.run(job, transfer);
  } finally {
    signal?.removeEventListener('abort', end);
    hand.end();
  }
}

// Workers that all hold the same scene.
export class Pool {
  constructor(module, count) {
    this.hands = Array.from({ length: count }, () => new Hand(module));
    this.free = [];
    this.queue = [];
    for (const hand of this.hands) hand.ready.then(() => this.release(hand), () => {});
  }

  // A job for whichever worker is free next. Those that are not `kept` can be dropped while they wait.
  run(job, { kept = false, transfer, first = false } = {}) {
    return new Promise((resolve, reject) => {
      const entry = { job, kept, transfer, resolve, reject };
      if (first) this.queue.unshift(entry);
      else this.queue.push(entry);
      this.next();
    });
  }

  // A job for every worker, after what it is doing.
  all(job) {
    return Promise.all(this.hands.map((hand) => hand.ready.then(() => hand.run(job))));
  }

  // Jobs that wait are dropped.
  drop() {
    const [kept, dropped] = [[], []];
    for (const entry of this.queue) (entry.kept ? kept : dropped).push(entry);
    this.queue = kept;
    dropped.forEach(({ resolve }) => resolve(DROPPED));
  }

  next() {
    while (this.free.length && this.queue.length) {
      const hand = this.free.pop();
      const { job, transfer, resolve, reject } = this.queue.shift();
      hand.run(job, transfer).then(resolve, reject).finally(() => this.release(hand));
    }
  }

  release(hand) {
    this.free.push(hand);
    this.next();
  }
}
