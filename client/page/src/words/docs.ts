// The texts of the page /docs. The descriptions of the interface come from the server.
export const words = {
  title: 'HTTP interface', loading: 'Asking the server …', absent: 'The server does not answer. Reload the page to try again.', token: 'This server needs a token', use: 'Use it',
  contents: 'Contents', home: 'Back to the page', search: 'Search', parameters: 'Parameters', raw: 'For programs:', headers: 'Headers',
  allParameters: (count: number) => `and ${count} parameters of fractures`, body: 'Body:',
};
