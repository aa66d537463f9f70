//! The worker's talk with the page: requests in, answers out.
//!
//! The page sends [`Message`]s. Each is answered by `{id, value}` or `{id, error}`, an error being
//! [`Failure`](crate::fault::Failure); before that a plan reports `{id, progress}` and, as far as there is something to
//! show, `{id, early}`. `{ended}` tells that a panic ends the module, and all that it was asked.
//!
//! Words and numbers become JSON, which browsers read fast; files and tables become arrays, whose memory goes over to
//! the page and is not copied once more.

use std::panic;

use evencut_service::results::OutputFile;
use evencut_service::stages::{done, words};
use js_sys::{Array, Float32Array, JSON, Object, Reflect, Uint8Array, Uint32Array, global};
use serde_json::{Value, json};
use wasm_bindgen::prelude::Closure;
use wasm_bindgen::{JsCast, JsValue, UnwrapThrowExt};
use web_sys::{DedicatedWorkerGlobalScope, MessageEvent};

use crate::answer::{Answer, answer};
use crate::plan::Plan;
use crate::request::Message;
use crate::tables::{Numbers, scales, tables};

/// Progress is reported at most this often, ms.
const PAUSE: f64 = 50.0;

/// Answers the messages of the page from now on.
pub fn start() {
    panic::set_hook(Box::new(|panic| {
        let message = format!("This is a bug in evencut: {panic}");
        post(&parsed(&json!({ "ended": { "message": message } }).to_string()), &Array::new());
    }));
    let take = Closure::<dyn Fn(MessageEvent)>::new(|event: MessageEvent| take(event.data()));
    scope().set_onmessage(Some(take.as_ref().unchecked_ref()));
    // It is listened to as long as the worker lives.
    take.forget();
}

/// Takes a message of the page.
fn take(data: JsValue) {
    let start = now();
    let Message { id, ask } = serde_wasm_bindgen::from_value(data)
        .unwrap_or_else(|error| panic!("a message of the page cannot be read: {error}"));
    let seconds = || (now() - start) / 1e3;
    let mut pace = Pace::default();
    let mut progress = |stage, part| {
        if pace.is_due(part, now()) {
            let (stage, done) = (words(stage), done(stage, part));
            Parcel::of(&json!({ "stage": stage, "done": done })).send(id, "progress");
        }
    };
    let mut show = |plan| Parcel::of_plan(plan, seconds()).send(id, "early");
    match answer(ask, &mut progress, &mut show) {
        Ok(Answer::Words(value)) => Parcel::of(&value).send(id, "value"),
        Ok(Answer::Plan(plan)) => Parcel::of_plan(*plan, seconds()).send(id, "value"),
        Ok(Answer::Texture { files, summary }) => {
            Parcel::of(&json!({ "summary": summary })).with_files(files).send(id, "value");
        }
        Err(failure) => Parcel::of(&json!(failure)).send(id, "error"),
    }
}

/// Says when progress is worth a message.
struct Pace {
    /// When it was reported last, ms.
    last: f64,
}

impl Default for Pace {
    fn default() -> Self {
        Self { last: f64::NEG_INFINITY }
    }
}

impl Pace {
    /// Whether to report, at a time in ms, that a part of a stage is done. That a stage begins always is.
    fn is_due(&mut self, part: f64, now: f64) -> bool {
        let is_due = part <= 0.0 || now - self.last >= PAUSE;
        if is_due {
            self.last = now;
        }
        is_due
    }
}

/// What goes to the page, and the memory that goes over with it.
struct Parcel {
    value: JsValue,
    memory: Array,
}

impl Parcel {
    /// Words and numbers.
    fn of(value: &Value) -> Self {
        Self { value: parsed(&value.to_string()), memory: Array::new() }
    }

    /// A plan, or what of it is there after so many seconds: its report and summary are null while it is only laid.
    fn of_plan(plan: Plan, seconds: f64) -> Self {
        let Plan { files, report, linked, job } = plan;
        let summary = report.as_ref().map(|report| report.summary());
        let parcel = Self::of(
            &json!({ "summary": summary, "scales": scales(&linked, &job), "seconds": seconds }),
        );
        let report = report.map_or(JsValue::NULL, |report| parsed(&report.to_json()));
        set(&parcel.value, "report", &report);
        let held = Object::new();
        for (name, numbers) in tables(&linked) {
            let (array, memory) = array(numbers);
            set(&held, name, &array);
            parcel.memory.push(&memory);
        }
        set(&parcel.value, "tables", &held);
        parcel.with_files(files)
    }

    /// The same with files, each `{name, bytes}`.
    fn with_files(self, files: Vec<OutputFile>) -> Self {
        let list = Array::new();
        // Each is given back as soon as it is copied.
        for OutputFile { name, bytes } in files {
            let (array, memory) = array(Numbers::Small(&bytes));
            let file = Object::new();
            set(&file, "name", &name.into());
            set(&file, "bytes", &array);
            list.push(&file);
            self.memory.push(&memory);
        }
        set(&self.value, "files", &list);
        self
    }

    /// Sends it about the request `id`, under a name that says what it is.
    fn send(self, id: u32, name: &str) {
        let message = Object::new();
        set(&message, "id", &id.into());
        set(&message, name, &self.value);
        post(&message, &self.memory);
    }
}

/// Numbers as a typed array, and its memory.
fn array(numbers: Numbers) -> (JsValue, JsValue) {
    match numbers {
        Numbers::Small(values) => {
            let array = Uint8Array::from(values);
            (array.clone().into(), array.buffer().into())
        }
        Numbers::Whole(values) => {
            let array = Uint32Array::from(values);
            (array.clone().into(), array.buffer().into())
        }
        Numbers::Single(values) => {
            let array = Float32Array::from(values);
            (array.clone().into(), array.buffer().into())
        }
    }
}

/// The value that JSON text tells.
fn parsed(json: &str) -> JsValue {
    JSON::parse(json).unwrap_throw()
}

fn set(object: &JsValue, name: &str, value: &JsValue) {
    Reflect::set(object, &name.into(), value).unwrap_throw();
}

/// Sends a message; what throws here, as where memory lacks, ends the worker.
fn post(message: &JsValue, memory: &Array) {
    if let Err(error) = scope().post_message_with_transfer(message, memory) {
        wasm_bindgen::throw_val(error);
    }
}

fn scope() -> DedicatedWorkerGlobalScope {
    global().unchecked_into()
}

/// The time, ms.
fn now() -> f64 {
    scope().performance().map_or(0.0, |clock| clock.now())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_is_reported_at_beginnings_and_then_not_too_often() {
        let mut pace = Pace::default();
        let times = [
            (0.1, 3.0),
            (0.2, 52.0),
            (0.3, 53.0),
            (0.4, 60.0),
            (0.0, 61.0),
            (0.1, 103.0),
            (0.2, 111.0),
        ];
        let due = times.map(|(part, now)| pace.is_due(part, now));
        assert_eq!(due, [true, false, true, false, true, false, true]);
    }
}
